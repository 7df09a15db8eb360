// Cells, tiles and the order of grains.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "../support/bed.hpp"
#include "core/cells.hpp"

namespace talus::core {
namespace {

CellGrid grid_of(int x, int y, int z, int tx, int ty, int tz) {
    CellGrid g;
    const int cells[3] = {x, y, z}, tiles[3] = {tx, ty, tz};
    for (int a = 0; a < 3; ++a) {
        g.cells[a] = cells[a];
        g.tiles[a] = tiles[a];
    }
    return g;
}

TEST(Cells, every_cell_lies_in_the_tile_whose_range_holds_it_and_has_a_rank_of_its_own) {
    for (const CellGrid& g : {grid_of(7, 5, 9, 3, 2, 4), grid_of(1, 1, 1, 1, 1, 1), grid_of(10, 1, 4, 5, 1, 2), grid_of(11, 6, 3, 4, 3, 1)}) {
        const CellOrder order(g);
        std::set<std::uint32_t> ranks;
        for (int x = 0; x < g.cells[0]; ++x)
            for (int y = 0; y < g.cells[1]; ++y)
                for (int z = 0; z < g.cells[2]; ++z) {
                    const std::uint32_t rank = order.rank_of(x, y, z);
                    EXPECT_LT(rank, g.n_cells());
                    EXPECT_TRUE(ranks.insert(rank).second);
                    const int c[3] = {x, y, z};
                    for (int a = 0; a < 3; ++a) {
                        const int t = g.tile_of_cell(a, c[a]);
                        EXPECT_LE(g.tile_begin(a, t), c[a]);
                        EXPECT_LT(c[a], g.tile_begin(a, t + 1));
                    }
                    const auto tile = static_cast<std::size_t>(order.tile_index(g.tile_of_cell(0, x), g.tile_of_cell(1, y), g.tile_of_cell(2, z)));
                    EXPECT_GE(rank, order.first_of_tile[tile]) << "tile-major";
                    EXPECT_LT(rank, order.first_of_tile[tile + 1]);
                }
        EXPECT_EQ(ranks.size(), g.n_cells());
        EXPECT_EQ(order.first_of_tile.back(), g.n_cells());
    }
}

TEST(Cells, are_at_least_one_reach_wide_tiles_at_least_two_cells_and_their_number_is_bounded_by_the_grains) {
    test::Random random(1);
    for (int k = 0; k < 2000; ++k) {
        Domain domain;
        double lo[3], hi[3];
        bool wraps[3];
        const double reach = random.uniform(0.1, 2.0);
        for (int a = 0; a < 3; ++a) {
            domain.lo[a] = random.uniform(-5.0, 5.0);
            domain.hi[a] = domain.lo[a] + random.uniform(2.0 * reach, 60.0);
            wraps[a] = domain.periodic[a] = random.uniform(0.0, 1.0) < 0.5;
            lo[a] = random.uniform(domain.lo[a], domain.hi[a]);
            hi[a] = k % 10 == 0 ? lo[a] : random.uniform(lo[a], domain.hi[a]);
        }
        const auto n = static_cast<std::size_t>(random.uniform(0.0, 5000.0)), tile_grains = static_cast<std::size_t>(random.uniform(1.0, 500.0));
        const CellGrid g = choose_grid(domain, lo, hi, reach, wraps, n, tile_grains);
        for (int a = 0; a < 3; ++a) {
            EXPECT_GE(g.cells[a], 1);
            if (g.cells[a] == 1) continue;
            EXPECT_GE((wraps[a] ? domain.length(a) : hi[a] - lo[a]) / g.cells[a], reach);
            for (int t = 0; g.tiles[a] > 1 && t < g.tiles[a]; ++t) EXPECT_GE(g.tile_begin(a, t + 1) - g.tile_begin(a, t), 2);
        }
        EXPECT_LE(g.n_cells(), 4.0 * static_cast<double>(n) + 64.0);
    }
}

TEST(Cells, coordinates_however_far_away_fall_into_the_end_cells) {
    CellGrid g = grid_of(5, 5, 5, 1, 1, 1);
    g.inverse_width[0] = 0.5;
    EXPECT_EQ(g.cell_along(0, -1e300), 0);
    EXPECT_EQ(g.cell_along(0, 1e300), 4);
    EXPECT_EQ(g.cell_along(0, -HUGE_VAL), 0);
    EXPECT_EQ(g.cell_along(0, HUGE_VAL), 4);
    EXPECT_EQ(g.cell_along(0, 0.0), 0);
    EXPECT_EQ(g.cell_along(0, 1.999), 0);
    EXPECT_EQ(g.cell_along(0, 2.0), 1);
    EXPECT_EQ(g.cell_along(0, 10.0), 4);
}

TEST(Cells, sorting_gives_cell_order_then_label_order_whatever_order_came_in) {
    test::Random random(8);
    for (int k = 0; k < 50; ++k) {
        const auto n = static_cast<std::size_t>(random.uniform(0.0, 400.0));
        const auto n_cells = static_cast<std::uint32_t>(random.uniform(1.0, 60.0));
        std::vector<std::uint32_t> cell(n);
        std::vector<Label> label(n);
        for (std::size_t i = 0; i < n; ++i) {
            cell[i] = static_cast<std::uint32_t>(random.uniform(0.0, n_cells));
            label[i] = static_cast<Label>((i * 7919) % 100003);
        }
        std::vector<std::uint32_t> first, order;
        sort_by_cell(std::span<const std::uint32_t>(cell), n_cells, [&](std::uint32_t i) { return label[i]; }, first, order);
        std::vector<std::uint32_t> expected(n);
        for (std::uint32_t i = 0; i < n; ++i) expected[i] = i;
        std::sort(expected.begin(), expected.end(), [&](std::uint32_t a, std::uint32_t b) { return std::pair(cell[a], label[a]) < std::pair(cell[b], label[b]); });
        EXPECT_EQ(order, expected);
        ASSERT_EQ(first.size(), n_cells + 1u);
        for (std::uint32_t c = 0; c < n_cells; ++c) EXPECT_EQ(first[c + 1] - first[c], std::count(cell.begin(), cell.end(), c));
    }
}

} // namespace
} // namespace talus::core
