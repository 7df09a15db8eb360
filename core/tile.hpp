// core/tile.hpp: one tile of a rank: its grains, the candidate pairs whose first grain it owns, their histories, and its sums.
//
// A tile writes nothing but its own rows: a partner that lives in another tile (or on another rank) has a border row here,
// which the partner's tile collects before it integrates. So force tasks need no order among themselves, and no atomics.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/cells.hpp"
#include "core/force_kernel.hpp"

namespace talus::core {

/// How far the grains of a tile moved since the lists were built, now and as foreseen. Empty: lo above hi.
struct DisplacementBox {
    double lo[3], hi[3];                   // m
    double foreseen_lo[3], foreseen_hi[3]; // m, a few steps on

    DisplacementBox() { clear(); }
    void clear() {
        for (int a = 0; a < 3; ++a) {
            lo[a] = foreseen_lo[a] = std::numeric_limits<double>::infinity();
            hi[a] = foreseen_hi[a] = -std::numeric_limits<double>::infinity();
        }
    }
    void add(const double (&now)[3], const double (&foreseen)[3]) {
        for (int a = 0; a < 3; ++a) {
            lo[a] = std::min(lo[a], now[a]);
            hi[a] = std::max(hi[a], now[a]);
            foreseen_lo[a] = std::min(foreseen_lo[a], foreseen[a]);
            foreseen_hi[a] = std::max(foreseen_hi[a], foreseen[a]);
        }
    }
    void merge(const DisplacementBox& b) {
        for (int a = 0; a < 3; ++a) {
            lo[a] = std::min(lo[a], b.lo[a]);
            hi[a] = std::max(hi[a], b.hi[a]);
            foreseen_lo[a] = std::min(foreseen_lo[a], b.foreseen_lo[a]);
            foreseen_hi[a] = std::max(foreseen_hi[a], b.foreseen_hi[a]);
        }
    }
    bool empty() const { return lo[0] > hi[0]; }
    /// Square of the largest relative displacement of two grains in the box.
    double relative_squared() const { return empty() ? 0.0 : diagonal(lo, hi); }
    double foreseen_squared() const { return empty() ? 0.0 : diagonal(foreseen_lo, foreseen_hi); }

private:
    static double diagonal(const double (&l)[3], const double (&h)[3]) {
        double s = 0.0;
        for (int a = 0; a < 3; ++a) s += (h[a] - l[a]) * (h[a] - l[a]);
        return s;
    }
};

/// Which contacts each own and each border grain of a tile has: made when its lists are given up or saved (core/contact_history.hpp).
struct ContactsByGrain {
    std::vector<std::uint32_t> first;  // [own and border grains + 1] into the two below; empty: not made
    std::vector<std::uint32_t> number; // of a contact: those of pairs, then those with each wall
    std::vector<std::uint32_t> key;    // low bits of the partner's label; may be read to seven places behind the end
};

/// The pairs of a tile that are near enough to touch before the next rebuild, not in its lists yet.
struct NearPairs {
    std::vector<CandidatePair> of_grains;
    std::vector<std::vector<CandidatePair>> with_walls; // {grain, grain}; one vector a wall
};

/// Border rows of another tile that belong to grains of this one.
struct IncomingSums {
    int from_tile;
    TileLocal first; // tile-local id there
    std::uint32_t count;
};

struct Tile {
    int index[3] = {0, 0, 0};        // place in the grid of tiles
    LocalIndex first = 0;            // owned grains [first, first + count)
    std::uint32_t count = 0;
    std::vector<LocalIndex> index_of;  // own grains, then border grains of this rank in order, then ghosts
    std::uint32_t n_border = 0;        // border rows that another tile collects
    std::vector<ForceSum> sums;        // one a tile-local id
    ContactList pairs;
    std::vector<ContactList> walls; // one a wall
    ContactsByGrain by_grain;
    std::vector<IncomingSums> incoming;
    std::vector<WallSum> wall_sums;     // one a wall, of the last force evaluation
    HeatSum heat;                       // since it was last collected
    CapBreach breach;
    DisplacementBox displacement;
    std::vector<int> neighbours;        // adjacent tiles, itself excluded
    std::vector<int> ghost_chunks;      // chunks of ghosts that its border holds
    std::vector<int> watched_chunks;    // chunks that lie near, with ghosts here or not: their displacements count for the skin
    double wall_clearance[kMaxWalls];   // m, how far a listed-out grain may come towards each wall
    bool finite = true;
    double seconds = 0.0;               // that its force and integration took since the lists were built

    /// Empty lists, for histories of so many doubles.
    void start_lists(std::size_t n_walls, int history_doubles) {
        pairs.start(history_doubles);
        walls.resize(n_walls);
        for (ContactList& w : walls) w.start(history_doubles);
        wall_sums.assign(n_walls, WallSum{});
    }
    /// Every contact starts anew, with histories of so many doubles.
    void void_histories(int doubles) {
        pairs.void_histories(doubles);
        for (ContactList& w : walls) w.void_histories(doubles);
    }
    /// Exchange the memory of lists with another tile's, and what is in it.
    void swap_memory(Tile& other) {
        index_of.swap(other.index_of);
        std::swap(pairs, other.pairs);
        walls.swap(other.walls);
    }
};

} // namespace talus::core
