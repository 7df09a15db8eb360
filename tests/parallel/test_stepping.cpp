// ranks: 1 2 3
// Steps in one call, in many, and with looks between that some ranks take and others do not: the same bits, and the right velocities.
#include "../support/determinism.hpp"
#include "../support/sheared_block.hpp"

namespace talus::test {
namespace {

constexpr int kSteps = 60;

World make_block() {
    HowToRun run = parallel_run();
    run.threads = 1;
    return make_sheared_block({12, 6, 10}, 0.3, run);
}

/// The velocities of this rank's grains, by label.
std::vector<double> velocities(World& world) {
    std::vector<double> v(3 * static_cast<std::size_t>(world.state().particles));
    int64_t n = 0;
    world.check(talus_particles_copy(world.handle(), TALUS_FIELD_VELOCITY, static_cast<int64_t>(v.size() / 3), v.data(), &n));
    v.resize(3 * static_cast<std::size_t>(n));
    return v;
}

talus_view view_of(World& world, int32_t field) {
    talus_view v;
    talus_view_init(&v);
    world.check(talus_particles_view(world.handle(), field, &v));
    return v;
}

TEST(Stepping, one_call_and_many_with_looks_on_some_ranks_have_the_same_bits) {
    World whole = make_block();
    whole.step(kSteps);
    const DigestBits expected = digest_of(whole.state());

    World single = make_block();
    for (int k = 0; k < kSteps; ++k) single.step(1);
    EXPECT_EQ(digest_of(single.state()), expected);

    World looked_at = make_block();
    for (int k = 0; k < kSteps; ++k) {
        looked_at.step(1);
        // Each rank alone, in steps of its own.
        if (k % (2 + looked_at.rank()) == 0) (void)view_of(looked_at, TALUS_FIELD_VELOCITY);
        if (k % 7 == 0) (void)looked_at.state();
        if (k % 11 == 0) looked_at.step(0);
    }
    EXPECT_EQ(digest_of(looked_at.state()), expected);
}

TEST(Stepping, the_velocities_after_a_call_are_those_at_the_end_of_its_last_step_whoever_asks_first) {
    World by_copy = make_block(), by_view = make_block();
    for (World* world : {&by_copy, &by_view}) world->step(kSteps);
    const std::vector<double> copied = velocities(by_copy);
    const talus_view view = view_of(by_view, TALUS_FIELD_VELOCITY);
    double sum_of_copy[3] = {0, 0, 0}, sum_of_view[3] = {0, 0, 0};
    for (std::size_t k = 0; k < copied.size(); ++k) sum_of_copy[k % 3] += std::fabs(copied[k]);
    for (int64_t k = 0; k < view.count; ++k)
        for (int a = 0; a < 3; ++a) sum_of_view[a] += std::fabs(reinterpret_cast<const double*>(reinterpret_cast<const char*>(view.data) + k * view.stride)[a]);
    for (int a = 0; a < 3; ++a) EXPECT_NEAR(sum_of_view[a], sum_of_copy[a], 1e-12 * (sum_of_copy[a] + 1.0));

    // A grain in free fall has exactly the velocity of its steps, full ones.
    talus_settings s = scene_settings({-1, -1, -1}, {1, 1, 1}, parallel_run());
    World fall(s, world_handle());
    const int32_t sand = fall.material(kSceneSand);
    fall.contact(sand, sand, 0.5, 0.5, 0.0);
    Grain grain;
    grain.radius = kSceneRadius;
    fall.insert({grain}, 0.05);
    for (int k = 1; k <= 5; ++k) {
        fall.step(1);
        const std::vector<double> v = velocities(fall);
        const double expected = k * s.time_step * s.gravity[1];
        if (!v.empty()) {
            EXPECT_NEAR(v[1], expected, 1e-12 * std::fabs(expected));
        }
    }
}

TEST(Stepping, what_changes_the_motion_between_calls_does_not_reach_back_into_the_last_step) {
    // Gravity and time step of the next step must not touch the half kick that the last one still owes.
    const auto turned = [](bool look_first) {
        World world = make_block();
        world.step(10);
        if (look_first) (void)world.state();
        const double up[3] = {0.0, 5.0, 0.0};
        world.check(talus_engine_set_gravity(world.handle(), up));
        double step = 0.0;
        world.check(talus_engine_critical_step(world.handle(), &step));
        world.check(talus_engine_set_time_step(world.handle(), 0.05 * step));
        const double drive[3] = {0.1, 0.0, 0.0};
        world.check(talus_group_set(world.handle(), 0, TALUS_GROUP_FREE, drive, nullptr));
        world.step(10);
        return digest_of(world.state());
    };
    EXPECT_EQ(turned(false), turned(true));
}

/// A floor that is driven back and forth, as a host that couples would.
void drive(World& world, int n) {
    for (int k = 0; k < n; ++k) {
        const double v[3] = {k % 2 == 0 ? 0.4 : -0.1, 0.0, 0.0};
        world.check(talus_wall_set_velocity(world.handle(), 0, v));
        world.step(3);
    }
}

TEST(Kept, a_state_is_come_back_to_bit_for_bit_as_often_as_wanted_through_rebuilds_and_moves_of_cuts) {
    World world = make_block(), other = make_block();
    world.step(20);
    const DigestBits at = digest_of(world.state());
    talus_kept* kept = nullptr;
    world.check(talus_engine_keep(world.handle(), &kept));
    EXPECT_EQ(digest_of(world.state()), at) << "keeping changes nothing";
    drive(world, 12);
    const DigestBits first = digest_of(world.state());
    EXPECT_NE(first, at);
    for (int again = 0; again < 3; ++again) {
        if (again == 1) world.step(5); // from wherever the last try ended, in the midst of a step's velocities
        world.check(talus_engine_restore(world.handle(), kept));
        if (again != 2) {
            EXPECT_EQ(digest_of(world.state()), at);
        }
        drive(world, 12);
        EXPECT_EQ(digest_of(world.state()), first);
    }
    EXPECT_EQ(talus_engine_restore(other.handle(), kept), TALUS_ERR_ARGUMENT);
    EXPECT_EQ(talus_engine_restore(world.handle(), nullptr), TALUS_ERR_ARGUMENT);
    other.step(20);
    EXPECT_EQ(digest_of(other.state()), at) << "refused, and whole";
    talus_kept_destroy(kept);
    talus_kept_destroy(nullptr);
}

} // namespace
} // namespace talus::test
