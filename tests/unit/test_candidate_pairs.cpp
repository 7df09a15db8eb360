// The candidate pairs of a rank against brute force, for few and many cells on periodic and closed axes.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <tuple>

#include "../support/lists.hpp"

namespace talus::core {
namespace {

using namespace test;

/// Brute force over all images.
std::set<PairOfLabels> brute_force(const System& s) {
    std::set<PairOfLabels> pairs;
    for (std::size_t i = 0; i < s.particles.size(); ++i)
        for (std::size_t j = i + 1; j < s.particles.size(); ++j) {
            const Particle &a = s.particles[i], &b = s.particles[j];
            bool near = false;
            for (int image = 0; image < 27; ++image) {
                const int shift[3] = {image / 9 - 1, image / 3 % 3 - 1, image % 3 - 1};
                double square = 0.0;
                bool exists = true;
                for (int c = 0; c < 3; ++c) {
                    exists = exists && (shift[c] == 0 || s.domain.periodic[c]);
                    const double d = a.position[c] - (b.position[c] + shift[c] * s.domain.length(c));
                    square += d * d;
                }
                const double reach = a.radius + b.radius + kSkin;
                near = near || (exists && square < reach * reach);
            }
            if (near) pairs.insert({std::min(a.label, b.label), std::max(a.label, b.label)});
        }
    return pairs;
}

void expect_equal_to_brute_force(const System& s, std::size_t tile_grains) {
    const Lists lists(s, tile_grains);
    std::set<PairOfLabels> found;
    for (const auto& [pair, times] : lists.listed()) {
        EXPECT_EQ(times, 1) << "pair " << pair.first << " " << pair.second;
        found.insert(pair);
    }
    EXPECT_EQ(found, brute_force(s));
}

/// Number of cells aimed at along an axis: the length is a little more than that many reaches.
double length_for(int cells) { return (cells + 0.17) * kReach; }

TEST(CandidatePairs, equal_brute_force_for_one_two_three_and_more_cells_on_every_mix_of_periodic_and_closed_axes) {
    int systems = 0;
    std::set<std::array<int, 3>> grids;
    for (int mask = 0; mask < 8; ++mask)
        for (int x = 1; x <= 5; ++x)
            for (int y = 1; y <= 4; ++y)
                for (int z = 1; z <= 3; ++z) {
                    const bool periodic[3] = {(mask & 1) != 0, (mask & 2) != 0, (mask & 4) != 0};
                    const int cells[3] = {x, y, z};
                    double lengths[3];
                    // A periodic axis is at least two reaches long; one cell on it comes of a coarser grid (next test).
                    for (int a = 0; a < 3; ++a) lengths[a] = length_for(periodic[a] ? std::max(2, cells[a]) : cells[a]);
                    const System s = random_system(lengths, periodic, 12 + 3 * x * y * z, static_cast<std::uint64_t>(1000 * mask + 100 * x + 10 * y + z));
                    SCOPED_TRACE("periodic mask " + std::to_string(mask) + ", cells " + std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(z));
                    const Lists lists(s, 8);
                    grids.insert({lists.order.grid.cells[0], lists.order.grid.cells[1], lists.order.grid.cells[2]});
                    for (const std::size_t tile_grains : {1u, 8u, 1000000u}) expect_equal_to_brute_force(s, tile_grains);
                    ++systems;
                }
    EXPECT_EQ(systems, 480);
    EXPECT_GT(grids.size(), 20u) << "many different grids must have been tried";
}

TEST(CandidatePairs, equal_brute_force_when_a_few_grains_in_a_wide_box_make_one_cell_of_a_periodic_axis) {
    std::set<int> cells_seen;
    for (int mask = 0; mask < 8; ++mask)
        for (std::uint64_t seed = 0; seed < 8; ++seed) {
            const bool periodic[3] = {(mask & 1) != 0, (mask & 2) != 0, (mask & 4) != 0};
            // Long in x: cells would outnumber grains by far, so they are widened until short axes are one cell across.
            const double lengths[3] = {400.0 * kReach, 2.05 * kReach, 2.0 * kReach};
            System s = random_system(lengths, periodic, 30, seed);
            for (std::size_t k = 0; k < s.particles.size(); ++k) s.particles[k].position[0] = s.domain.lo[0] + (k < 15 ? 0.002 : 0.9985) * lengths[0] + 0.1 * static_cast<double>(k % 15);
            if (!periodic[0]) {
                s.particles[0].position[0] = s.domain.lo[0];
                s.particles[29].position[0] = s.domain.hi[0];
            }
            const Lists lists(s, 4);
            cells_seen.insert(lists.order.grid.cells[1]);
            expect_equal_to_brute_force(s, 4);
        }
    EXPECT_TRUE(cells_seen.contains(1));
}

TEST(CandidatePairs, equal_brute_force_in_a_dense_system_for_every_size_of_tiles) {
    const double lengths[3] = {length_for(6), length_for(4), length_for(5)};
    for (const bool wraps : {false, true}) {
        const bool periodic[3] = {wraps, false, wraps};
        const System s = random_system(lengths, periodic, 700, 99);
        std::set<int> numbers_of_tiles;
        for (const std::size_t tile_grains : {1, 3, 10, 30, 100, 300, 699, 700, 100000}) {
            numbers_of_tiles.insert(Lists(s, tile_grains).order.grid.n_tiles());
            expect_equal_to_brute_force(s, tile_grains);
        }
        EXPECT_GE(numbers_of_tiles.size(), 4u);
        EXPECT_TRUE(numbers_of_tiles.contains(1));
    }
}

TEST(CandidatePairs, equal_brute_force_where_single_precision_cannot_tell_them) {
    // Few grains in a box of a million radii make few cells, so a tile spans it; pairs are a billionth of the skin within reach or out of it.
    const double lengths[3] = {1e6, 2e5, 3e5};
    System s = random_system(lengths, {false, false, false}, 80, 12);
    Random random(3);
    for (std::size_t k = 0; k + 1 < s.particles.size(); k += 2) {
        Particle &a = s.particles[k], &b = s.particles[k + 1];
        for (int c = 0; c < 3; ++c) b.position[c] = a.position[c];
        const double distance = a.radius + b.radius + kSkin * (1.0 + (k % 4 == 0 ? 1e-9 : -1e-9));
        b.position[k % 3] += a.position[k % 3] < s.domain.lo[k % 3] + 0.5 * lengths[k % 3] ? distance : -distance;
    }
    for (const std::size_t tile_grains : {5u, 1000u}) expect_equal_to_brute_force(s, tile_grains);
    const std::size_t near = brute_force(s).size();
    EXPECT_GT(near, 10u);
    EXPECT_LT(near, 30u);
}

TEST(CandidatePairs, list_the_same_pairs_whatever_the_order_in_which_grains_are_given) {
    const double lengths[3] = {length_for(3), length_for(2), length_for(4)};
    const System s = random_system(lengths, {true, false, true}, 120, 5);
    System reversed = s;
    std::reverse(reversed.particles.begin(), reversed.particles.end());
    const Lists one(s, 20), other(reversed, 20);
    ASSERT_EQ(one.particles.size(), other.particles.size());
    for (std::size_t k = 0; k < one.particles.size(); ++k) EXPECT_EQ(one.particles[k].label, other.particles[k].label);
    EXPECT_EQ(one.listed(), other.listed());
}

TEST(CandidatePairs, link_every_border_row_to_the_tile_of_its_grain_exactly_once) {
    const double lengths[3] = {length_for(5), length_for(4), length_for(4)};
    for (const bool wraps : {false, true}) {
        const System s = random_system(lengths, {wraps, false, wraps}, 500, 17);
        const Lists lists(s, 25);
        ASSERT_GT(lists.tiles.size(), 6u);
        std::set<std::pair<int, TileLocal>> linked; // tile and row there
        for (std::size_t t = 0; t < lists.tiles.size(); ++t)
            for (const IncomingSums& in : lists.tiles[t].incoming) {
                const Tile& from = lists.tiles[static_cast<std::size_t>(in.from_tile)];
                EXPECT_NE(in.from_tile, static_cast<int>(t));
                EXPECT_TRUE(std::ranges::binary_search(lists.tiles[t].neighbours, in.from_tile)) << "a border can only come from a neighbour";
                for (TileLocal id = in.first; id < in.first + in.count; ++id) {
                    EXPECT_TRUE(linked.insert({in.from_tile, id}).second) << "a row collected twice";
                    EXPECT_GE(from.index_of[id], lists.tiles[t].first);
                    EXPECT_LT(from.index_of[id], lists.tiles[t].first + lists.tiles[t].count);
                }
            }
        std::size_t rows = 0;
        for (const Tile& t : lists.tiles) {
            EXPECT_EQ(t.index_of.size(), t.count + t.n_border);
            EXPECT_EQ(t.sums.size(), t.index_of.size());
            rows += t.n_border;
            std::set<LocalIndex> used;
            for (const LocalIndex i : t.index_of) EXPECT_TRUE(used.insert(i).second) << "a grain has one row a tile";
        }
        EXPECT_EQ(linked.size(), rows);
        EXPECT_GT(rows, 50u);
    }
}

TEST(CandidatePairs, neighbours_are_mutual_and_name_no_tile_twice_or_itself) {
    const double lengths[3] = {length_for(8), length_for(4), length_for(4)};
    const Lists lists(random_system(lengths, {true, true, false}, 600, 3), 20);
    for (std::size_t t = 0; t < lists.tiles.size(); ++t) {
        const auto& n = lists.tiles[t].neighbours;
        EXPECT_EQ(std::set<int>(n.begin(), n.end()).size(), n.size());
        for (const int u : n) {
            EXPECT_NE(u, static_cast<int>(t));
            EXPECT_TRUE(std::ranges::binary_search(lists.tiles[static_cast<std::size_t>(u)].neighbours, static_cast<int>(t)));
        }
    }
}

TEST(CandidatePairs, list_a_wall_for_exactly_the_grains_whose_gap_is_below_the_skin_and_tell_the_least_gap_of_the_others) {
    const double lengths[3] = {length_for(4), length_for(4), length_for(3)};
    const System s = random_system(lengths, {false, false, true}, 200, 31);
    const std::vector<WallPlane> walls{{{0.0, s.domain.lo[1], 0.0}, {0.0, 1.0, 0.0}, {0, 0, 0}, 0}, {{s.domain.hi[0], 0.0, 0.0}, {-0.6, 0.8, 0.0}, {0, 0, 0}, 0}};
    const Lists lists(s, 30, walls);
    for (std::size_t w = 0; w < walls.size(); ++w) {
        std::multiset<Label> listed, expected;
        for (const Tile& t : lists.tiles) {
            double clearance = HUGE_VAL;
            for (LocalIndex i = t.first; i < t.first + t.count; ++i) {
                const Particle& p = lists.particles[i];
                const double gap = dot(make_vec3(p.position) - walls[w].point, walls[w].normal) - p.radius;
                if (gap < kSkin)
                    expected.insert(p.label);
                else
                    clearance = std::min(clearance, gap);
            }
            EXPECT_EQ(t.wall_clearance[w], clearance);
            t.walls[w].each_pair([&](CandidatePair pair) { listed.insert(lists.particles[t.index_of[pair.i]].label); });
        }
        EXPECT_EQ(listed, expected);
        EXPECT_GT(listed.size(), 3u);
    }
}

} // namespace
} // namespace talus::core
