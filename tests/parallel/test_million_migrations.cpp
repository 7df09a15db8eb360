// ranks: 4
// timeout: 300
// A million migrations: the hash over all histories, which the digest is part of, and their number stay what they were.
#include "../support/determinism.hpp"

namespace talus::test {
namespace {

constexpr int64_t kMigrations = 1'000'000;

TEST(MillionMigrations, lose_and_change_no_contact_and_no_grain) {
    for (const Scene& scene : {kShear, kPeriodic}) {
        SCOPED_TRACE(scene.name);
        HowToRun run;
        run.comm = world_handle();
        run.rebalance = TALUS_REBALANCE_RANDOM;
        run.tile_grains = 60;
        World world = scene.make(run);
        World still = scene.make(HowToRun{}); // the same on each rank for itself
        const int64_t rounds = 20;
        for (int64_t round = 1; round <= rounds; ++round) {
            // Some steps, then rebuilds with other cuts each time, none of which may be seen.
            world.step(10);
            still.step(10);
            const talus_state before = world.state();
            ASSERT_EQ(digest_of(before), digest_of(still.state()));
            while (world.state().migrations < kMigrations / 2 * round / rounds) {
                int64_t removed = -1;
                world.check(talus_particles_remove_above(world.handle(), 1, 1e9, &removed)); // a rebuild that touches no grain
                const talus_state after = world.state();
                ASSERT_EQ(digest_of(after), digest_of(before));
                ASSERT_EQ(after.contacts, before.contacts);
                ASSERT_EQ(after.wall_contacts, before.wall_contacts);
                ASSERT_EQ(after.sliding_contacts, before.sliding_contacts);
                ASSERT_EQ(after.particles, before.particles);
            }
        }
        const talus_state end = world.state();
        EXPECT_GT(end.sliding_contacts, 0);
        if (world.rank() == 0) std::printf("%s: %lld migrations in %lld rebuilds\n", scene.name, static_cast<long long>(end.migrations), static_cast<long long>(end.rebuilds));
    }
}

} // namespace
} // namespace talus::test
