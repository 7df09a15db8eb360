// ranks: 64
// label: slow
// timeout: 3600
// Many more ranks than processors, and than a bed of this size would ever be given.
#include "../support/determinism.hpp"

namespace talus::test {
namespace {

TEST(ManyRanks, run_two_thousand_steps_of_a_small_bed_with_the_bits_of_one) {
    const talus_state reference = serial_reference(kShear, 2000);
    HowToRun run;
    run.comm = world_handle();
    run.rebalance = TALUS_REBALANCE_AUTO;
    World world = kShear.make(run);
    kShear.advance(world, 0, 2000, 2000);
    const talus_state s = world.state();
    EXPECT_EQ(digest_of(s), digest_of(reference));
    EXPECT_EQ(s.contacts, reference.contacts);
    EXPECT_EQ(s.ranks, 64);
    if (world.rank() == 0) std::printf("64 ranks: %lld rebuilds, %lld moves of cuts, %lld migrations, %lld messages a step\n", static_cast<long long>(s.rebuilds), static_cast<long long>(s.rebalances), static_cast<long long>(s.migrations), static_cast<long long>(s.halo_messages));
}

} // namespace
} // namespace talus::test
