// lists.hpp: random grains, and the candidate lists of one rank over them as binning and pair_build of the runtime make them.
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <vector>

#include "bed.hpp"
#include "core/candidate_pairs.hpp"

namespace talus::test {

using namespace talus::core;

inline constexpr double kRadiusMax = 1.0, kSkin = 0.3, kReach = 2.0 * kRadiusMax + kSkin;

struct System {
    Domain domain;
    std::vector<Particle> particles;
};

/// Random grains; overlaps do no harm to lists. Some stand exactly on faces and corners of the domain.
inline System random_system(const double (&lengths)[3], const bool (&periodic)[3], int n, std::uint64_t seed) {
    System s;
    Random random(seed);
    for (int a = 0; a < 3; ++a) {
        s.domain.lo[a] = -1.0 + 0.5 * a;
        s.domain.hi[a] = s.domain.lo[a] + lengths[a];
        s.domain.periodic[a] = periodic[a];
    }
    for (int k = 0; k < n; ++k) {
        Particle p{};
        for (int a = 0; a < 3; ++a) {
            p.position[a] = random.uniform(s.domain.lo[a], s.domain.hi[a]);
            if (k % 7 == a) p.position[a] = s.domain.lo[a];
            if (k % 11 == a && !periodic[a]) p.position[a] = s.domain.hi[a];
        }
        p.radius = random.uniform(0.5 * kRadiusMax, kRadiusMax);
        p.label = (k * 7919LL) % 10007; // unrelated to place
        s.particles.push_back(p);
    }
    return s;
}

using PairOfLabels = std::pair<Label, Label>;

/// What bin_grains and build_pairs of the runtime do on one rank without ghosts.
struct Lists {
    std::vector<Particle> particles;
    CellOrder order;
    std::vector<std::uint32_t> cell_first;
    std::vector<Tile> tiles;
    std::vector<NearPairs> near; // of each tile; candidates in its lists

    Lists(const System& s, std::size_t tile_grains, const std::vector<WallPlane>& walls = {}, int history_doubles = 4) : particles(s.particles) {
        double lo[3] = {1e300, 1e300, 1e300}, hi[3] = {-1e300, -1e300, -1e300};
        for (const Particle& p : particles)
            for (int a = 0; a < 3; ++a) {
                lo[a] = std::min(lo[a], p.position[a]);
                hi[a] = std::max(hi[a], p.position[a]);
            }
        const auto n = static_cast<std::uint32_t>(particles.size());
        order = CellOrder(choose_grid(s.domain, lo, hi, kReach, s.domain.periodic, n, tile_grains));
        std::vector<std::uint32_t> cell(n), sorted;
        for (std::uint32_t i = 0; i < n; ++i) cell[i] = order.rank_of(particles[i].position);
        sort_by_cell(std::span<const std::uint32_t>(cell), order.grid.n_cells(), [&](std::uint32_t i) { return particles[i].label; }, cell_first, sorted);
        std::vector<Particle> in_order;
        for (const std::uint32_t i : sorted) in_order.push_back(particles[i]);
        particles = in_order;
        const CellGrid& grid = order.grid;
        tiles.resize(static_cast<std::size_t>(grid.n_tiles()));
        for (int t = 0; t < grid.n_tiles(); ++t) {
            Tile& tile = tiles[static_cast<std::size_t>(t)];
            tile.index[0] = t / (grid.tiles[1] * grid.tiles[2]);
            tile.index[1] = t / grid.tiles[2] % grid.tiles[1];
            tile.index[2] = t % grid.tiles[2];
            tile.first = cell_first[order.first_of_tile[static_cast<std::size_t>(t)]];
            tile.count = cell_first[order.first_of_tile[static_cast<std::size_t>(t) + 1]] - tile.first;
        }
        link_neighbours(order, tiles);
        const CandidateSource source{particles, n, order, cell_first, {}, {}, {}, {}, walls, kSkin};
        CandidateScratch scratch;
        for (Tile& t : tiles) {
            build_candidates(source, t, scratch);
            near.push_back(scratch.near);
            t.start_lists(walls.size(), history_doubles);
            t.pairs.set_candidates(scratch.near.of_grains);
            for (std::size_t w = 0; w < walls.size(); ++w) t.walls[w].set_candidates(scratch.near.with_walls[w]);
        }
        link_borders(tiles);
    }

    /// Every listed pair as often as it stands.
    std::map<PairOfLabels, int> listed() const {
        std::map<PairOfLabels, int> pairs;
        for (const Tile& t : tiles)
            t.pairs.each_pair([&](CandidatePair pair) {
                const Label a = particles[t.index_of[pair.i]].label, b = particles[t.index_of[pair.j]].label;
                EXPECT_LT(a, b) << "i has the smaller label";
                EXPECT_LT(pair.own(), t.count) << "one of the two is the tile's";
                ++pairs[{std::min(a, b), std::max(a, b)}];
            });
        return pairs;
    }
};

} // namespace talus::test
