// ranks: 1 2 3
// What is observed of contacts (stress, unbalanced force, energies) has the same bits on any ranks: contacts across subdomains are seen
// with the velocities that both grains have now.
#include "../support/determinism.hpp"
#include "../support/sheared_block.hpp"

namespace talus::test {
namespace {

constexpr int64_t kSteps = 40;

struct Seen {
    double stress[9], solid_fraction, coordination, unbalanced, elastic;
};

Seen look(World& world) {
    Seen seen{};
    const double lo[3] = {0, 0, 0}, hi[3] = {8 * kSceneRadius, 8 * kSceneRadius, 8 * kSceneRadius};
    world.check(talus_engine_stress(world.handle(), lo, hi, seen.stress, &seen.solid_fraction, &seen.coordination));
    seen.unbalanced = world.state().unbalanced_force;
    talus_energy energy;
    talus_energy_init(&energy);
    world.check(talus_engine_energy(world.handle(), &energy));
    seen.elastic = energy.elastic_normal + energy.elastic_tangential;
    return seen;
}

TEST(Observation, has_the_same_bits_on_any_ranks) {
    Seen serial{};
    if (world_rank_of_me() == 0) {
        World world = make_sheared_block({12, 6, 10}, 0.5, HowToRun{});
        world.step(kSteps);
        serial = look(world);
    }
    MPI_Bcast(&serial, sizeof serial, MPI_BYTE, 0, MPI_COMM_WORLD);
    HowToRun run = parallel_run();
    World world = make_sheared_block({12, 6, 10}, 0.5, run);
    world.step(kSteps);
    const Seen seen = look(world);
    for (int k = 0; k < 9; ++k) EXPECT_EQ(seen.stress[k], serial.stress[k]) << "component " << k;
    EXPECT_EQ(seen.solid_fraction, serial.solid_fraction);
    EXPECT_EQ(seen.coordination, serial.coordination);
    EXPECT_EQ(seen.unbalanced, serial.unbalanced);
    EXPECT_EQ(seen.elastic, serial.elastic);
    EXPECT_GT(serial.unbalanced, 0.0);
}

} // namespace
} // namespace talus::test
