#include "core/balance.hpp"

#include <algorithm>
#include <cmath>

namespace talus::core {

namespace {

constexpr double kFine = 0.125; // of a part's cost: a bin that holds no more of it places a cut well enough

} // namespace

CostProfile::CostProfile(const SliceGrid& cuts, int axis, double lo, double hi)
    : cuts_(cuts), axis_(axis), parts_(cuts.grid()[axis]), bins_of_part_(std::max(kLeastBinsOfPart, kLeastBins / parts_)), lo_(lo), hi_(std::max(lo, hi)) {
    const int groups = cuts.n_groups(axis);
    for (int g = 0; g < groups; ++g) {
        ends_.push_back(lo_);
        for (int p = 1; p < parts_; ++p) ends_.push_back(std::clamp(cuts.cuts(axis)[static_cast<std::size_t>(g) * (parts_ - 1) + p - 1], ends_.back(), hi_));
        ends_.push_back(hi_);
    }
    cost_.assign(static_cast<std::size_t>(groups) * n_bins(), 0);
}

std::size_t CostProfile::bin(int group, double x) const {
    const double* ends = ends_.data() + static_cast<std::size_t>(group) * (parts_ + 1);
    const std::size_t part = static_cast<std::size_t>(std::upper_bound(ends + 1, ends + parts_, x) - (ends + 1));
    const double width = ends[part + 1] - ends[part];
    const double share = width > 0.0 ? (x - ends[part]) / width : 0.0;
    return part * bins_of_part_ + static_cast<std::size_t>(std::clamp(static_cast<int>(share * bins_of_part_), 0, bins_of_part_ - 1));
}

bool CostProfile::cut(const CutLimits& limits, const SliceGrid& from, SliceGrid& out) const {
    bool fine = true;
    const double least = std::min(limits.least, (hi_ - lo_) / parts_);
    for (int g = 0; g < cuts_.n_groups(axis_); ++g) {
        const double* ends = ends_.data() + static_cast<std::size_t>(g) * (parts_ + 1);
        const std::int64_t* cost = cost_.data() + static_cast<std::size_t>(g) * n_bins();
        const std::size_t first = static_cast<std::size_t>(g) * (parts_ - 1);
        double* cuts = out.cuts(axis_).data() + first;
        std::int64_t total = 0;
        for (std::size_t b = 0; b < n_bins(); ++b) total += cost[b];
        std::size_t bin = 0;
        std::int64_t below = 0; // cost of the bins before `bin`
        for (int p = 1; p < parts_; ++p) {
            double& at = cuts[p - 1];
            if (total == 0) {
                at = lo_ + (hi_ - lo_) * p / parts_;
                continue;
            }
            const double target = static_cast<double>(total) * p / parts_;
            while (bin + 1 < n_bins() && static_cast<double>(below + cost[bin]) < target) below += cost[bin++];
            const double share = cost[bin] > 0 ? std::clamp((target - static_cast<double>(below)) / static_cast<double>(cost[bin]), 0.0, 1.0) : 0.5;
            const std::size_t part = bin / bins_of_part_;
            at = ends[part] + (ends[part + 1] - ends[part]) * ((static_cast<double>(bin % bins_of_part_) + share) / bins_of_part_);
            fine = fine && static_cast<double>(cost[bin]) * parts_ <= kFine * static_cast<double>(total);
        }
        // Keep every part wide enough: push up from below, then down from above.
        for (int p = 1; p < parts_; ++p) cuts[p - 1] = std::max(cuts[p - 1], (p == 1 ? lo_ : cuts[p - 2]) + least);
        for (int p = parts_ - 1; p >= 1; --p) cuts[p - 1] = std::min(cuts[p - 1], (p == parts_ - 1 ? hi_ : cuts[p]) - least);
        for (int p = 1; p < parts_; ++p) {
            const double old = from.cuts(axis_)[first + static_cast<std::size_t>(p) - 1];
            cuts[p - 1] = std::clamp(cuts[p - 1], old - limits.most_move, old + limits.most_move);
        }
    }
    return fine || std::isfinite(limits.most_move);
}

double BalanceLedger::waste(double most, double mean, double steps) { return std::max(0.0, most - kReachable * mean) * steps; }

void BalanceLedger::add(double most, double mean, double steps) {
    if (most < kGoodEnough * mean)
        wasted_ = 0.0; // a wave of noise ends here
    else
        wasted_ += waste(most, mean, steps);
}

} // namespace talus::core
