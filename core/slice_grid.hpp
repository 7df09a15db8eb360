// core/slice_grid.hpp: subdomains by the slice grid of Furuichi and Nishiura (2017): slabs in x, cut in z within each slab, then
// in y. A pure algorithm: cuts are real numbers, the same on every rank; they decide who works, never what comes out.
#pragma once

#include <array>
#include <vector>

#include "core/domain.hpp"

namespace talus::core {

struct Box {
    double lo[3], hi[3]; // m; infinite at the outer ends of the slice grid
};

class SliceGrid {
public:
    SliceGrid() = default;
    /// Equal slices of the domain. @param grid subdomains along x, y, z
    SliceGrid(const Domain& domain, const std::array<int, 3>& grid);

    int n_ranks() const { return grid_[0] * grid_[1] * grid_[2]; }
    const std::array<int, 3>& grid() const { return grid_; }
    int rank_at(int ix, int iy, int iz) const { return (ix * grid_[2] + iz) * grid_[1] + iy; }
    /// The owner of a position; positions beyond the outer ends belong to the end slices.
    int owner(const double* position) const;
    Box box(int rank) const;
    /// Parts that are cut on their own along an axis: the domain along x, each slab along z, each column of a slab along y.
    int n_groups(int axis) const { return axis == 0 ? 1 : axis == 2 ? grid_[0] : grid_[0] * grid_[2]; }
    /// The group that a position belongs to; it depends on the cuts of the axes before (x, z, y) only.
    int group(int axis, const double* position) const;
    /// Cuts along an axis inside the domain, [n_groups(axis)][grid()[axis] - 1].
    std::vector<double>& cuts(int axis) { return cuts_[axis]; }
    const std::vector<double>& cuts(int axis) const { return cuts_[axis]; }

    bool operator==(const SliceGrid&) const = default;

private:
    std::array<int, 3> grid_{1, 1, 1};
    std::vector<double> cuts_[3];
};

/// Half of the surface that a subdomain of a box shows others at most, the measure of halos. An axis that is not cut has no such faces;
/// a closed one cut in two has one a subdomain, else there are two.
double halo_surface(const std::array<int, 3>& grid, const double (&lengths)[3], const bool (&periodic)[3]);

/// Factors of n_ranks along x, y, z for which subdomains have the least halo_surface; axes given (> 0) are kept.
/// @return {0, 0, 0} if the given axes do not divide n_ranks
std::array<int, 3> choose_rank_grid(int n_ranks, const double (&lengths)[3], const bool (&periodic)[3], const std::array<int, 3>& given);

} // namespace talus::core
