// ranks: 2
// label: slow
// timeout: 1800
// Load balance by the clock: needs two processors that nobody else uses. Shares of work are asserted, speeds too, medians of windows.
#include <sched.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

#include "../support/determinism.hpp"
#include "../support/sheared_block.hpp"

namespace talus::test {
namespace {

constexpr int64_t kWindow = 40; // steps that are timed together

runtime::EngineState& inside(World& world) { return world.handle()->engine->state(); }

/// Some 80,000 grains on a floor that moves, cut along x.
World make_bed(int32_t policy) {
    HowToRun run;
    run.comm = world_handle();
    run.rebalance = policy;
    run.tile_grains = 0;
    run.rank_grid[0] = 2;
    World world = make_sheared_block({80, 16, 64}, 0.5, run);
    world.step(20);
    return world;
}

/// Give rank 0 nine tenths of the grains.
void spoil(World& world) {
    runtime::EngineState& s = inside(world);
    const runtime::Rebalance policy = s.model.settings.rebalance;
    s.model.settings.rebalance = runtime::Rebalance::off;
    s.slices.cuts(0)[0] = 0.9 * 80 * 2.0 * kSceneRadius;
    int64_t removed = -1;
    world.check(talus_particles_remove_above(world.handle(), 1, 1e9, &removed));
    s.model.settings.rebalance = policy;
}

double seconds_of_window(World& world) {
    MPI_Barrier(MPI_COMM_WORLD);
    const auto from = std::chrono::steady_clock::now();
    world.step(kWindow);
    double t = std::chrono::duration<double>(std::chrono::steady_clock::now() - from).count();
    MPI_Bcast(&t, 1, MPI_DOUBLE, 0, MPI_COMM_WORLD);
    return t;
}

double share_of(World& world, int rank) {
    double mine = static_cast<double>(inside(world).sub.n_owned) / static_cast<double>(inside(world).model.n_particles);
    MPI_Bcast(&mine, 1, MPI_DOUBLE, rank, MPI_COMM_WORLD);
    return mine;
}

double median(std::vector<double> v) {
    std::sort(v.begin(), v.end());
    return v[v.size() / 2];
}

void keep_to(int processor) {
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(processor, &one);
    ASSERT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
}

TEST(LoadBalance, a_run_that_starts_with_nine_tenths_on_one_rank_reaches_the_speed_of_one_cut_perfectly) {
    World world = make_bed(TALUS_REBALANCE_AUTO), perfect = make_bed(TALUS_REBALANCE_OFF);
    spoil(world);
    EXPECT_NEAR(share_of(world, 0), 0.9, 0.02);
    const double at_first = seconds_of_window(world);
    int windows = 1;
    for (; share_of(world, 0) > 0.6 && windows < 50; ++windows) seconds_of_window(world);
    std::vector<double> ratio, fast;
    for (int k = 0; k < 15; ++k) { // in turn, since the machine's speed changes
        fast.push_back(seconds_of_window(perfect));
        ratio.push_back(fast.back() / seconds_of_window(world));
    }
    if (world.rank() == 0)
        std::printf("90 %%: first window %.2f times a perfect one, balanced after %d windows of %lld steps with %lld moves of cuts; then %.3f of the perfect speed (%.3f to %.3f), share %.3f, perfect %.3f\n",
                    at_first / median(fast), windows, static_cast<long long>(kWindow), static_cast<long long>(inside(world).counters.rebalances), median(ratio), *std::min_element(ratio.begin(), ratio.end()),
                    *std::max_element(ratio.begin(), ratio.end()), share_of(world, 0), share_of(perfect, 0));
    EXPECT_GT(inside(world).counters.rebalances, 0);
    EXPECT_GE(median(ratio), 0.95);
}

TEST(LoadBalance, automatic_balance_costs_less_than_a_hundredth_where_none_is_needed) {
    World off = make_bed(TALUS_REBALANCE_OFF), automatic = make_bed(TALUS_REBALANCE_AUTO);
    std::vector<double> ratio;
    for (int k = 0; k < 41; ++k) {
        const double a = seconds_of_window(automatic), b = seconds_of_window(off), c = seconds_of_window(off), d = seconds_of_window(automatic);
        ratio.push_back((a + d) / (b + c));
    }
    if (off.rank() == 0)
        std::printf("auto: %.4f of the time without (quartiles %.4f and %.4f), %lld moves of cuts in %lld rebuilds, phase rebalance %.4f of busy time\n", median(ratio), (std::sort(ratio.begin(), ratio.end()), ratio[10]), ratio[30],
                    static_cast<long long>(inside(automatic).counters.rebalances), static_cast<long long>(inside(automatic).counters.rebuilds),
                    inside(automatic).workers.total(runtime::Phase::rebalance).seconds / inside(automatic).workers.busy());
    EXPECT_LT(median(ratio), 1.01);
}

TEST(LoadBalance, a_rank_at_half_speed_ends_with_half_of_the_others_work) {
    keep_to(world_rank_of_me());
    World world = make_bed(TALUS_REBALANCE_AUTO);
    std::atomic<bool> over{false};
    std::thread hog; // on the processor of rank 1, which the system shares out evenly
    if (world.rank() == 1) hog = std::thread([&] { while (!over.load(std::memory_order_relaxed)) {} });
    std::vector<double> shares;
    for (int k = 0; k < 40; ++k) {
        seconds_of_window(world);
        if (k >= 25) shares.push_back(share_of(world, 1));
    }
    over = true;
    if (hog.joinable()) hog.join();
    if (world.rank() == 0) std::printf("half speed: rank 1 has %.3f of the grains (%.3f to %.3f), %lld moves of cuts\n", median(shares), *std::min_element(shares.begin(), shares.end()), *std::max_element(shares.begin(), shares.end()), static_cast<long long>(inside(world).counters.rebalances));
    EXPECT_NEAR(median(shares), 1.0 / 3.0, 0.05);
}

} // namespace
} // namespace talus::test
