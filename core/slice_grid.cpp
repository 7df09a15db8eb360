#include "core/slice_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace talus::core {

namespace {

/// Slice of a value among sorted cuts: the number of cuts at or below it.
int slice_of(const double* cuts, int n, double x) {
    return static_cast<int>(std::upper_bound(cuts, cuts + n, x) - cuts);
}

} // namespace

SliceGrid::SliceGrid(const Domain& domain, const std::array<int, 3>& grid) : grid_(grid) {
    const auto equal = [&](int axis, int copies) {
        const int n = grid_[axis];
        for (int copy = 0; copy < copies; ++copy)
            for (int k = 1; k < n; ++k) cuts_[axis].push_back(domain.lo[axis] + domain.length(axis) * k / n);
    };
    equal(0, 1);
    equal(2, grid_[0]);
    equal(1, grid_[0] * grid_[2]);
}

int SliceGrid::owner(const double* p) const {
    const int nx = grid_[0], ny = grid_[1], nz = grid_[2];
    const int ix = slice_of(cuts_[0].data(), nx - 1, p[0]);
    const int iz = slice_of(cuts_[2].data() + static_cast<std::size_t>(ix) * (nz - 1), nz - 1, p[2]);
    const int iy = slice_of(cuts_[1].data() + static_cast<std::size_t>(ix * nz + iz) * (ny - 1), ny - 1, p[1]);
    return rank_at(ix, iy, iz);
}

Box SliceGrid::box(int rank) const {
    const int nx = grid_[0], ny = grid_[1], nz = grid_[2];
    const int iy = rank % ny, iz = rank / ny % nz, ix = rank / (ny * nz);
    constexpr double inf = std::numeric_limits<double>::infinity();
    Box b;
    const auto side = [&](int axis, const double* cuts, int n, int i) {
        b.lo[axis] = i == 0 ? -inf : cuts[i - 1];
        b.hi[axis] = i == n - 1 ? inf : cuts[i];
    };
    side(0, cuts_[0].data(), nx, ix);
    side(2, cuts_[2].data() + static_cast<std::size_t>(ix) * (nz - 1), nz, iz);
    side(1, cuts_[1].data() + static_cast<std::size_t>(ix * nz + iz) * (ny - 1), ny, iy);
    return b;
}

std::array<int, 3> choose_rank_grid(int n_ranks, const double (&lengths)[3], const std::array<int, 3>& given) {
    std::array<int, 3> best{0, 0, 0};
    double least = std::numeric_limits<double>::infinity();
    for (int x = 1; x <= n_ranks; ++x) {
        if (n_ranks % x != 0 || (given[0] > 0 && given[0] != x)) continue;
        for (int y = 1; y <= n_ranks / x; ++y) {
            const int z = n_ranks / x / y;
            if (n_ranks / x % y != 0 || (given[1] > 0 && given[1] != y) || (given[2] > 0 && given[2] != z)) continue;
            const double a = lengths[0] / x, b = lengths[1] / y, c = lengths[2] / z;
            // Only axes that are cut have halo faces.
            const double surface = (x > 1 ? b * c : 0.0) + (y > 1 ? a * c : 0.0) + (z > 1 ? a * b : 0.0);
            if (surface < least) {
                least = surface;
                best = {x, y, z};
            }
        }
    }
    return best;
}

void cut_histogram(const std::int64_t* cost, int n, double lo, double hi, int parts, double least, double* out) {
    std::int64_t total = 0;
    for (int k = 0; k < n; ++k) total += cost[k];
    const double width = (hi - lo) / n;
    int bin = 0;
    std::int64_t below = 0; // cost of bins before `bin`
    for (int p = 1; p < parts; ++p) {
        if (total == 0) {
            out[p - 1] = lo + (hi - lo) * p / parts;
        } else {
            const double target = static_cast<double>(total) * p / parts;
            while (bin < n - 1 && static_cast<double>(below + cost[bin]) < target) below += cost[bin++];
            const double share = cost[bin] > 0 ? (target - static_cast<double>(below)) / static_cast<double>(cost[bin]) : 0.5;
            out[p - 1] = lo + width * (bin + std::clamp(share, 0.0, 1.0));
        }
    }
    // Keep every part wide enough: push up from below, then down from above.
    for (int p = 1; p < parts; ++p) out[p - 1] = std::max(out[p - 1], (p == 1 ? lo : out[p - 2]) + least);
    for (int p = parts - 1; p >= 1; --p) out[p - 1] = std::min(out[p - 1], (p == parts - 1 ? hi : out[p]) - least);
}

} // namespace talus::core
