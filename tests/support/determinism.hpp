// determinism.hpp: one scene run in many ways, each compared with a serial run on one thread. For tests over ranks.
#pragma once

#include <gtest/gtest.h>
#include <mpi.h>

#include <array>
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "capi/src/guard.hpp"
#include "scenes.hpp"

namespace talus::test {

using DigestBits = std::array<uint64_t, 2>;
inline DigestBits digest_of(const talus_state& s) { return {s.digest_hi, s.digest_lo}; }

inline int32_t world_handle() { return MPI_Comm_c2f(MPI_COMM_WORLD); }
inline int world_size() {
    int n = 1;
    MPI_Comm_size(MPI_COMM_WORLD, &n);
    return n;
}
inline int world_rank_of_me() {
    int n = 0;
    MPI_Comm_rank(MPI_COMM_WORLD, &n);
    return n;
}

/// On all ranks and two threads, with cuts that move at every rebuild.
inline HowToRun parallel_run() {
    HowToRun run;
    run.comm = world_handle();
    run.threads = 2;
    run.rebalance = TALUS_REBALANCE_EVERY;
    return run;
}

/// The state at the end of a serial run with one thread, by rank 0, known to all.
inline talus_state serial_reference(const Scene& scene, int64_t steps) {
    talus_state state;
    talus_state_init(&state);
    if (world_rank_of_me() == 0) {
        World world = scene.make(HowToRun{});
        scene.advance(world, 0, steps, steps);
        state = world.state();
        std::printf("digest %s %" PRId64 " steps %016" PRIx64 "%016" PRIx64 " contacts %" PRId64 " sliding %" PRId64 " rebuilds %" PRId64 "\n", scene.name, steps, state.digest_hi, state.digest_lo,
                    state.contacts, state.sliding_contacts, state.rebuilds);
        std::fflush(stdout);
    }
    MPI_Bcast(&state, sizeof state, MPI_BYTE, 0, MPI_COMM_WORLD);
    return state;
}

/// The runs of this rank count that belong to a set which covers all pairs of values of ranks, threads, skin and rebalancing: three for
/// each of the rank counts 1, 2, 3, 4 and 6. With the environment variable TALUS_COVERING_PART = 0, 1 or 2 only one of the three, such
/// that three builds, each with a part of its own, cover the pairs with the builds too.
inline std::vector<HowToRun> covering_runs() {
    constexpr int kRanks[] = {1, 2, 3, 4, 6};
    constexpr double kSkins[] = {0.05, 0.2, 0.0}; // the last one: automatic
    constexpr int kShift[] = {0, 1, 2, 1, 0};       // such that skins meet all values of the others, and all parts
    constexpr int32_t kRebalance[] = {TALUS_REBALANCE_OFF, TALUS_REBALANCE_EVERY, TALUS_REBALANCE_RANDOM};
    int r = 0;
    while (r < 4 && kRanks[r] < world_size()) ++r;
    std::vector<HowToRun> runs;
    const char* part = std::getenv("TALUS_COVERING_PART");
    for (int t = 0; t < 3; ++t) {
        if (part != nullptr && t != (r + std::atoi(part)) % 3) continue;
        HowToRun run;
        run.comm = world_handle();
        run.threads = t + 1;
        run.skin = kSkins[(kShift[r] + t) % 3];
        run.rebalance = kRebalance[(r + t) % 3];
        run.tile_grains = 8 + 16 * ((r + 2 * t) % 3); // few, so that a sixth of a scene still has a tile for every thread
        runs.push_back(run);
    }
    return runs;
}

/// Run a scene in every way of the covering set and compare.
inline void expect_same_bits(const Scene& scene, int64_t steps) {
    const talus_state reference = serial_reference(scene, steps);
    EXPECT_GT(reference.contacts, scene.slides ? 100 : 0);
    EXPECT_GE(reference.sliding_contacts, scene.slides ? 1 : 0);
    EXPECT_GT(reference.rebuilds, 3) << "lists must have been rebuilt to prove anything";
    for (const HowToRun& run : covering_runs()) {
        SCOPED_TRACE(std::string(scene.name) + ": threads " + std::to_string(run.threads) + ", skin " + std::to_string(run.skin) + " d, rebalance " + std::to_string(run.rebalance));
        World world = scene.make(run);
        scene.advance(world, 0, steps, steps);
        const talus_state s = world.state();
        EXPECT_EQ(digest_of(s), digest_of(reference));
        EXPECT_EQ(s.contacts, reference.contacts);
        EXPECT_EQ(s.sliding_contacts, reference.sliding_contacts);
        EXPECT_EQ(s.particles, reference.particles);
        EXPECT_EQ(s.kinetic_energy, reference.kinetic_energy);
        EXPECT_EQ(s.max_overlap, reference.max_overlap);
        EXPECT_EQ(s.ranks, world_size());
        EXPECT_EQ(s.threads_observed, run.threads);
        EXPECT_GE(s.migrations, world_size() > 1 && run.rebalance != TALUS_REBALANCE_OFF ? 1 : 0) << "moved cuts must have moved grains";
    }
}

} // namespace talus::test
