// apps/bench/balance_study.hpp: the balancer at full size, in one process: the cost field of a real bed, repeated until it holds
// billions of grains, cut for thousands of ranks (core/balance.hpp, the very code that a run calls).
#pragma once

#include <string>

#include "apps/sandbox/bed_file.hpp"

namespace talus::bench {

struct BalanceOptions {
    double grains = 2.4e9;   // of the field; those of the bed are repeated or stand for several
    bool whole = false;      // the bed is stretched along x as a whole (a wedge), not repeated there; along z it is always repeated
    double step = 1.0;       // a grain of half of the field, cut off obliquely, costs so many times that of the others
    double reach = 0.0;      // m, width of a halo: with it, what the paper's way takes, which moves a cut by one halo at a time; 0: left out
    std::string json;        // file for the figures; empty: none
};

/// Print, for 64, 1024 and 16,384 subdomains: max/mean of cost from equal volumes on, rebalance by rebalance, the time of one call, the
/// floor that whole grains set, and the number of rebalances that cuts held to a halo width need.
void study_balance(const sandbox::Bed& bed, const BalanceOptions& options);

} // namespace talus::bench
