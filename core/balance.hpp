// core/balance.hpp: cuts of the slice grid for which all subdomains cost the same. A pure algorithm: a cost field and cuts in, cuts
// out; who holds the field, and on how many ranks, is the caller's business.
// Source   Furuichi and Nishiura (2017): slabs in x, cut in z within each slab, then in y; they relax each cut by the difference of
//          cost of its two sides, with multigrid for the long waves. Here the cuts are solved for: along each axis the cost is summed
//          in bins that follow the present cuts (CostProfile), and the new cuts are where its running sum reaches equal
//          shares. That takes one sum over all ranks of as many numbers as there are bins, and is done after one or two of them
//          however far the cuts have to go; relaxation takes a sum for each halo width of the way.
// Symbols  cost is a count of any unit; sums are integers, so that all ranks find the same cuts to the bit
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "core/slice_grid.hpp"

namespace talus::core {

// Bins of a group, and of each of its parts, at least: what is in one bin is placed by interpolation.
inline constexpr int kLeastBins = 1024, kLeastBinsOfPart = 16;
inline constexpr int kMostSums = 4;    // of one axis in one balance
inline constexpr double kReachable = 1.01;    // max/mean that a move of cuts leaves
inline constexpr double kGoodEnough = 1.04;   // max/mean that is forgiven: below it measured times tell noise

struct CutLimits {
    double least = 0.0;                                             // m, width that every part keeps
    double most_move = std::numeric_limits<double>::infinity();     // m, of a cut at once
};

/// The cost along one axis of each group of subdomains that is cut on its own.
class CostProfile {
public:
    /// Empty bins between lo and hi, as many to each part of `cuts`. Keeps a reference to `cuts`.
    CostProfile(const SliceGrid& cuts, int axis, double lo, double hi);

    void add(const double* position, std::int64_t cost) {
        const int group = cuts_.group(axis_, position);
        cost_[static_cast<std::size_t>(group) * n_bins() + bin(group, position[axis_])] += cost;
    }
    /// To be summed over ranks. [n_groups][parts * bins of a part]
    std::vector<std::int64_t>& cost() { return cost_; }
    /// Write cuts into `out` that share the cost of each group out equally, within limits; a move counts from the cuts in `from`.
    /// @return whether every cut fell into a bin that holds little of a part's cost (else bins that follow the new cuts find better)
    bool cut(const CutLimits& limits, const SliceGrid& from, SliceGrid& out) const;

private:
    std::size_t n_bins() const { return static_cast<std::size_t>(parts_ * bins_of_part_); }
    std::size_t bin(int group, double x) const;

    const SliceGrid& cuts_;
    int axis_, parts_, bins_of_part_;
    double lo_, hi_;
    std::vector<double> ends_; // [n_groups][parts + 1]
    std::vector<std::int64_t> cost_;
};

/// Balanced cuts. @param extent  where there is cost, finite; the same on every rank
/// @param collect  collect(profile): add the cost of everything to the profile, then sum it over ranks
template <class Collect>
SliceGrid balance(const SliceGrid& now, const Box& extent, const CutLimits& limits, Collect collect) {
    SliceGrid cuts = now;
    for (const int axis : {0, 2, 1}) {
        if (cuts.grid()[axis] == 1) continue;
        for (int sum = 0; sum < kMostSums; ++sum) {
            const SliceGrid binned = cuts;
            CostProfile profile(binned, axis, extent.lo[axis], extent.hi[axis]);
            collect(profile);
            if (profile.cut(limits, now, cuts)) break;
        }
    }
    return cuts;
}

/// Whether moving cuts pays, told of every list's life: what imbalance has cost since cuts last moved against what a move costs. All it
/// is told must be the same on every rank.
class BalanceLedger {
public:
    /// @param most, mean  seconds a step takes the slowest rank, and the mean of all @param steps  of a list's life
    void add(double most, double mean, double steps);
    void add_price(double seconds) { price_ = price_ > 0.0 ? price_ + 0.5 * (seconds - price_) : seconds; }
    bool pays() const { return wasted_ > price_; }
    void moved() { wasted_ = 0.0; }
    double price() const { return price_; } // s
    /// Seconds that the slowest rank loses in so many steps against what a move of cuts can reach.
    static double waste(double most, double mean, double steps);

private:
    double wasted_ = 0.0, price_ = 0.0; // s
};

} // namespace talus::core
