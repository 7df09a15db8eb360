// runtime/settings.hpp: what an engine is told at creation.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "core/domain.hpp"
#include "core/force_kernel.hpp"
#include "core/material.hpp"

namespace talus::runtime {

enum class Rebalance : std::int32_t { off = 0, automatic = 1, every = 2, random = 3 };

struct Settings {
    core::Domain domain;
    int threads = 1;
    double gravity[3] = {0.0, -9.81, 0.0};
    double time_step = 0.0;
    double time_step_limit = 0.5;
    double skin = 0.0; // 0: chosen at rebuilds
    double radius_max = 0.0;
    int tile_grains = 0;
    Rebalance rebalance = Rebalance::automatic;
    int rebalance_interval = 1; // rebuilds, of every and random
    std::array<int, 3> rank_grid{0, 0, 0};
    bool energy_ledger = false;
    std::uint64_t seed = 1;
    core::Laws laws;
    core::KernelWidth width = core::KernelWidth::automatic;
};

/// Every fault of the settings, one a line; empty when they are fine.
std::string settings_faults(const Settings& s, int n_ranks);
/// Every fault of a set of laws.
std::string laws_faults(const core::Laws& laws);

inline constexpr int kMaxThreads = 1024;
inline constexpr int kDefaultTileGrains = 1024;    // records, sums, pairs and histories of a tile then fit in L2

} // namespace talus::runtime
