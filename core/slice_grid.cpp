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
    for (int axis = 0; axis < 3; ++axis) equal(axis, n_groups(axis));
}

int SliceGrid::group(int axis, const double* p) const {
    if (axis == 0) return 0;
    const int nx = grid_[0], nz = grid_[2];
    const int ix = slice_of(cuts_[0].data(), nx - 1, p[0]);
    if (axis == 2) return ix;
    return ix * nz + slice_of(cuts_[2].data() + static_cast<std::size_t>(ix) * (nz - 1), nz - 1, p[2]);
}

int SliceGrid::owner(const double* p) const {
    const int ny = grid_[1], column = group(1, p);
    return column * ny + slice_of(cuts_[1].data() + static_cast<std::size_t>(column) * (ny - 1), ny - 1, p[1]);
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

double halo_surface(const std::array<int, 3>& grid, const double (&lengths)[3], const bool (&periodic)[3]) {
    double surface = 0.0;
    for (int a = 0; a < 3; ++a) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        const double face = lengths[b] / grid[b] * (lengths[c] / grid[c]);
        if (grid[a] > 1) surface += grid[a] == 2 && !periodic[a] ? 0.5 * face : face;
    }
    return surface;
}

std::array<int, 3> choose_rank_grid(int n_ranks, const double (&lengths)[3], const bool (&periodic)[3], const std::array<int, 3>& given) {
    std::array<int, 3> best{0, 0, 0};
    double least = std::numeric_limits<double>::infinity();
    for (int x = 1; x <= n_ranks; ++x) {
        if (n_ranks % x != 0 || (given[0] > 0 && given[0] != x)) continue;
        for (int y = 1; y <= n_ranks / x; ++y) {
            const int z = n_ranks / x / y;
            if (n_ranks / x % y != 0 || (given[1] > 0 && given[1] != y) || (given[2] > 0 && given[2] != z)) continue;
            const double surface = halo_surface({x, y, z}, lengths, periodic);
            if (surface < least) {
                least = surface;
                best = {x, y, z};
            }
        }
    }
    return best;
}

} // namespace talus::core
