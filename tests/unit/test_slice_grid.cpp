// The slice grid: every place has one owner.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "../support/bed.hpp"
#include "core/slice_grid.hpp"

namespace talus::core {
namespace {

Domain domain_of(double x, double y, double z) {
    Domain d;
    d.hi[0] = x;
    d.hi[1] = y;
    d.hi[2] = z;
    return d;
}

TEST(SliceGrid, every_place_lies_in_the_box_of_its_owner_and_in_no_other_and_a_cut_belongs_to_the_upper_side) {
    test::Random random(1);
    SliceGrid grid(domain_of(4.0, 2.0, 3.0), {3, 2, 4});
    for (int a = 0; a < 3; ++a) // cuts anywhere, each slab with its own
        for (double& c : grid.cuts(a)) c += random.uniform(-0.2, 0.2);
    for (int k = 0; k < 5000; ++k) {
        double x[3] = {random.uniform(-1.0, 5.0), random.uniform(-1.0, 3.0), random.uniform(-1.0, 4.0)};
        if (k % 5 == 0) x[0] = grid.cuts(0)[static_cast<std::size_t>(k) % 2];
        const int owner = grid.owner(x);
        EXPECT_EQ(grid.group(2, x), owner / 8) << "slabs of four by two";
        EXPECT_EQ(grid.group(1, x), owner / 2) << "columns of two";
        int holders = 0;
        for (int r = 0; r < grid.n_ranks(); ++r) {
            const Box b = grid.box(r);
            bool in = true;
            for (int a = 0; a < 3; ++a) in = in && x[a] >= b.lo[a] && x[a] < b.hi[a];
            if (!in) continue;
            ++holders;
            EXPECT_EQ(r, owner);
        }
        EXPECT_EQ(holders, 1);
    }
}

TEST(SliceGrid, slices_are_equal_at_first_and_open_at_the_outer_ends) {
    const SliceGrid grid(domain_of(6.0, 2.0, 3.0), {3, 1, 1});
    EXPECT_EQ(grid.cuts(0), (std::vector<double>{2.0, 4.0}));
    EXPECT_TRUE(std::isinf(grid.box(0).lo[0]));
    EXPECT_TRUE(std::isinf(grid.box(2).hi[0]));
    EXPECT_EQ(grid.box(1).lo[0], 2.0);
    EXPECT_EQ(grid.box(1).hi[0], 4.0);
    const double far[3] = {1e300, -1e300, 0.0};
    EXPECT_EQ(grid.owner(far), 2);
}

TEST(SliceGrid, ranks_are_factored_into_the_subdomains_of_least_surface_and_given_axes_are_kept) {
    const bool closed[3] = {false, false, false};
    const double sheet[3] = {10.0, 1.0, 1.0};
    EXPECT_EQ(choose_rank_grid(6, sheet, closed, {0, 0, 0}), (std::array<int, 3>{6, 1, 1}));
    const double slab[3] = {10.0, 0.5, 10.0};
    EXPECT_EQ(choose_rank_grid(16, slab, closed, {0, 0, 0}), (std::array<int, 3>{4, 1, 4}));
    for (int n = 1; n <= 60; ++n) {
        const auto g = choose_rank_grid(n, slab, closed, {0, 0, 0});
        EXPECT_EQ(g[0] * g[1] * g[2], n);
    }
    // A period is cut in two places at once: two ranks had rather share the longer side between walls.
    const double box[3] = {1.0, 5.0, 1.1};
    const bool along_z[3] = {false, false, true};
    EXPECT_EQ(choose_rank_grid(2, box, closed, {0, 1, 0}), (std::array<int, 3>{1, 1, 2}));
    EXPECT_EQ(choose_rank_grid(2, box, along_z, {0, 1, 0}), (std::array<int, 3>{2, 1, 1}));
    EXPECT_EQ(choose_rank_grid(12, slab, closed, {0, 3, 0})[1], 3);
    EXPECT_EQ(choose_rank_grid(12, slab, closed, {2, 3, 2}), (std::array<int, 3>{2, 3, 2}));
    EXPECT_EQ(choose_rank_grid(12, slab, closed, {5, 0, 0}), (std::array<int, 3>{0, 0, 0})) << "five does not divide twelve";
    EXPECT_EQ(choose_rank_grid(12, slab, closed, {2, 2, 2}), (std::array<int, 3>{0, 0, 0}));
}

} // namespace
} // namespace talus::core
