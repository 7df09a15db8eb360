// ranks: 2
// label: slow
// timeout: 1800
// Two processors used in three ways, on 400,000 grains: two independent engines at once, one engine of two threads, one over two ranks.
// In turn, a few steps each, so that a machine whose speed changes does not decide; medians of ratios.
#include <algorithm>
#include <chrono>
#include <thread>

#include "../support/determinism.hpp"
#include "../support/sheared_block.hpp"

namespace talus::test {
namespace {

constexpr int kWindow = 20, kRounds = 31; // steps of a window

World make_bed(int32_t comm, int32_t threads) {
    HowToRun run;
    run.comm = comm;
    run.threads = threads;
    run.rebalance = TALUS_REBALANCE_AUTO;
    run.skin = 0.0;
    run.tile_grains = 0;
    World world = make_sheared_block({80, 64, 80}, 0.1, run);
    world.step(30);
    return world;
}

/// Wait for all ranks without taking a processor, but for what is done meanwhile.
template <class Meanwhile>
void wait_for_all(Meanwhile meanwhile) {
    MPI_Request barrier;
    MPI_Ibarrier(MPI_COMM_WORLD, &barrier);
    for (int done = 0; !done;) {
        MPI_Test(&barrier, &done, MPI_STATUS_IGNORE);
        if (!done) meanwhile();
    }
}
/// Seldom awake: somebody else is being timed.
void rest_until_all_are_here() {
    wait_for_all([] { std::this_thread::sleep_for(std::chrono::milliseconds(20)); });
}

/// Steps a second of a world; zero on a rank that has none.
/// @param beside_others  it goes on until the other ranks' windows are over too, so that nobody is timed on a machine for himself
double speed(World* world, bool beside_others) {
    rest_until_all_are_here();
    wait_for_all([] {}); // to start together
    double v = 0.0;
    if (world != nullptr) {
        const auto from = std::chrono::steady_clock::now();
        world->step(kWindow);
        v = kWindow / std::chrono::duration<double>(std::chrono::steady_clock::now() - from).count();
    }
    if (beside_others)
        wait_for_all([&] { world->step(1); });
    else
        rest_until_all_are_here();
    return v;
}

/// Steps a second of a copy beside the other, one call a step. Tied, it begins no step before the other has begun the one before: what
/// any run that is cut in equal halves can reach on these processors.
double speed_step_by_step(World& copy, bool tied) {
    rest_until_all_are_here();
    wait_for_all([] {});
    MPI_Request other = MPI_REQUEST_NULL;
    const auto from = std::chrono::steady_clock::now();
    for (int k = 0; k < kWindow; ++k) {
        MPI_Wait(&other, MPI_STATUS_IGNORE);
        if (tied) MPI_Ibarrier(MPI_COMM_WORLD, &other);
        copy.step(1);
    }
    MPI_Wait(&other, MPI_STATUS_IGNORE);
    const double v = kWindow / std::chrono::duration<double>(std::chrono::steady_clock::now() - from).count();
    wait_for_all([&] { copy.step(1); });
    return v;
}

double sum_over_ranks(double v) {
    double sum = 0.0;
    MPI_Allreduce(&v, &sum, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
    return sum;
}

std::string quartiles(std::vector<double> v) {
    std::sort(v.begin(), v.end());
    char text[64];
    std::snprintf(text, sizeof text, "%.3f (%.3f to %.3f)", v[v.size() / 2], v[v.size() / 4], v[3 * v.size() / 4]);
    return text;
}

TEST(Scaling, threads_and_ranks_keep_the_speed_of_independent_copies) {
    const bool first = world_rank_of_me() == 0;
    World copy = make_bed(TALUS_SERIAL, 1), ranks = make_bed(world_handle(), 1);
    std::unique_ptr<World> threads;
    if (first) threads = std::make_unique<World>(make_bed(TALUS_SERIAL, 2));
    std::vector<double> by_threads, by_ranks, alone, speeds, tied;
    for (int k = 0; k < kRounds; ++k) {
        const double copies = sum_over_ranks(speed(&copy, true));
        const double free = sum_over_ranks(speed_step_by_step(copy, false));
        tied.push_back(sum_over_ranks(speed_step_by_step(copy, true)) / free);
        by_threads.push_back(sum_over_ranks(speed(threads.get(), false)) / copies);
        by_ranks.push_back(0.5 * sum_over_ranks(speed(&ranks, false)) / copies);
        alone.push_back(2.0 * sum_over_ranks(speed(first ? &copy : nullptr, false)) / copies);
        speeds.push_back(copies * 409600e-6);
    }
    const talus_state s = ranks.state();
    if (first)
        std::printf("copies %s M particle-steps/s; of copies: one rank of two threads %s, two ranks of one %s; a copy alone %s of its speed beside the other, copies that wait for each other in every step %s of such that do not; %lld ghosts a rank\n", quartiles(speeds).c_str(), quartiles(by_threads).c_str(), quartiles(by_ranks).c_str(),
                    quartiles(alone).c_str(), quartiles(tied).c_str(), static_cast<long long>(s.ghosts));
    std::sort(by_threads.begin(), by_threads.end());
    std::sort(by_ranks.begin(), by_ranks.end());
    EXPECT_GE(sum_over_ranks(first ? by_threads[kRounds / 2] : 0.0), 0.97);
    EXPECT_GE(sum_over_ranks(first ? by_ranks[kRounds / 2] : 0.0), 0.97);
}

} // namespace
} // namespace talus::test
