// ranks: 1 2 4
// timeout: 240
// The automatic skin: wide in a gas, narrow in a bed at rest, within the room that the domain leaves, the same on all ranks.
#include "../support/determinism.hpp"

namespace talus::test {
namespace {

constexpr double kD = 2.0 * kSceneRadius;

HowToRun automatic() {
    HowToRun run = parallel_run();
    run.threads = 1;
    run.skin = 0.0;
    return run;
}

/// Grains 1.3 diameters apart at first.
World make_thin_gas(const Vec3& size, double speed, const HowToRun& run) {
    std::array<int, 3> n;
    for (std::size_t a = 0; a < 3; ++a) n[a] = static_cast<int>(size[a] / (1.3 * kD));
    return make_elastic_gas(size, n, speed, 10.0, 29, run);
}

/// A lattice that hardly moves, on a floor, with light gravity. Its uppermost layer is group 1.
World make_still_bed(const HowToRun& run) {
    const Vec3 size{12 * kD, 8 * kD, 12 * kD};
    talus_settings s = scene_settings({0, -kD, 0}, {size[0], size[1] + kD, size[2]}, run);
    s.periodic[0] = s.periodic[2] = 1;
    s.gravity[1] = -1e-3;
    World world(s, run.comm);
    const int32_t sand = world.material(kSceneSand);
    world.contact(sand, sand, 0.3, 0.5, 0.1);
    world.wall(sand, {0, 0, 0}, {0, 1, 0});
    std::vector<Grain> grains = lattice(12, 8, 12, {0, 0, 0}, 0.0, 0.0);
    for (Grain& g : grains) g.group = g.position[1] > 7 * kD ? 1 : 0;
    world.insert(grains, 0.1);
    return world;
}

void expect_same_skin_everywhere(const talus_state& s) {
    double skin = s.skin;
    MPI_Bcast(&skin, 1, MPI_DOUBLE, 0, MPI_COMM_WORLD);
    EXPECT_EQ(s.skin, skin);
}

TEST(AutomaticSkin, starts_at_a_tenth_of_the_diameter_and_becomes_wide_in_a_gas_and_narrow_in_a_bed_at_rest) {
    World gas = make_thin_gas({12 * kD, 12 * kD, 12 * kD}, 2.0, automatic());
    EXPECT_DOUBLE_EQ(gas.state().skin, 0.1 * kD);
    gas.step(300);
    const talus_state flying = gas.state();
    expect_same_skin_everywhere(flying);
    EXPECT_GT(flying.skin, 0.15 * kD);
    EXPECT_LE(flying.skin, 0.5 * kD * (1 + 1e-12));

    World bed = make_still_bed(automatic());
    bed.step(3000);
    const talus_state still = bed.state();
    expect_same_skin_everywhere(still);
    EXPECT_LT(still.skin, 0.09 * kD);
    EXPECT_GE(still.skin, 0.02 * kD * (1 - 1e-12));
    EXPECT_LT(still.rebuilds, 20) << "a bed at rest has no other reason to rebuild its lists";
}

TEST(AutomaticSkin, keeps_to_the_room_of_a_short_periodic_axis_where_a_wider_one_would_be_refused) {
    HowToRun run = automatic();
    run.rank_grid[0] = 1;
    const double length = 2.0 * (kD + 0.12 * kD);
    World gas = make_thin_gas({length, 14 * kD, 14 * kD}, 0.3, run);
    gas.step(300);
    EXPECT_GT(gas.state().skin, 0.1 * kD);
    EXPECT_LE(gas.state().skin, 0.12 * kD);
    EXPECT_GT(gas.state().rebuilds, 10);

    HowToRun wide = run;
    wide.skin = 0.15;
    EXPECT_THROW(make_thin_gas({length, 14 * kD, 14 * kD}, 0.3, wide), TalusError);
    EXPECT_THROW(make_thin_gas({2.0 * (kD + 0.09 * kD), 14 * kD, 14 * kD}, 0.3, run), TalusError) << "there must be room for the first skin";
}

TEST(AutomaticSkin, keeps_to_the_width_of_subdomains) {
    if (world_size() == 1) GTEST_SKIP() << "needs subdomains";
    HowToRun run = automatic();
    run.rank_grid[0] = world_size();
    World gas = make_thin_gas({1.13 * kD * std::max(2, world_size()), 14 * kD, 14 * kD}, 0.3, run);
    gas.step(300);
    EXPECT_GT(gas.state().skin, 0.1 * kD);
    EXPECT_LE(gas.state().skin, 0.13 * kD);
}

TEST(AutomaticSkin, is_at_least_the_first_one_again_when_the_host_sets_grains_in_motion) {
    World bed = make_still_bed(automatic());
    bed.step(3000);
    ASSERT_LT(bed.state().skin, 0.09 * kD);
    const double up[3] = {0.0, 0.06 * kD / kSceneStep, 0.0}; // in one step farther than the narrow skin
    ASSERT_GT(up[1] * kSceneStep, bed.state().skin);
    bed.check(talus_group_set(bed.handle(), 1, TALUS_GROUP_DRIVEN, up, nullptr));
    bed.step(1);
    EXPECT_GE(bed.state().skin, 0.1 * kD * (1 - 1e-12));
    bed.step(3);
}

TEST(AutomaticSkin, gives_the_bits_of_a_pinned_one_that_stays_as_it_is) {
    const talus_state reference = serial_reference(kGas, 300);
    EXPECT_DOUBLE_EQ(reference.skin, 0.1 * kD);
    World gas = make_gas(automatic());
    gas.step(300);
    EXPECT_EQ(digest_of(gas.state()), digest_of(reference));
    EXPECT_NE(gas.state().skin, reference.skin);
}

} // namespace
} // namespace talus::test
