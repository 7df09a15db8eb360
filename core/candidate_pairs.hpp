// core/candidate_pairs.hpp: the pairs of grains near enough to touch before the next rebuild, found through cells.
//
// A pair is listed when the gap between two surfaces is below the skin. Each pair of owned grains stands once, in the tile of
// one of them; a pair with a ghost stands on both ranks. Which images are near is decided here, with explicit shifts; the
// kernel then takes the minimum image, which is the same one since periods are at least twice the reach.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/cells.hpp"
#include "core/tile.hpp"

namespace talus::core {

/// What a rank's tiles are built from. Ghosts stand behind the owned grains and keep their owner's coordinates; `shift` is
/// what brings each near this rank.
struct CandidateSource {
    const std::vector<Particle>& particles;
    LocalIndex n_owned;
    const CellOrder& order;
    std::span<const std::uint32_t> cell_first;  // [n_cells + 1] owned grains, which stand in cell order
    std::span<const std::uint32_t> ghost_first; // [n_cells + 1]
    std::span<const std::uint32_t> ghost_order; // ghost numbers in cell order
    std::span<const Vec3d> ghost_shift;         // [n_ghosts] m
    std::span<const std::int32_t> ghost_chunk;  // [n_ghosts] chunk of the halo it came with
    std::span<const WallPlane> walls;
    double skin;
};

/// Scratch of one worker.
struct CandidateScratch {
    struct Cell {
        std::uint32_t rank = 0;
        std::uint32_t first = 0, last = 0;             // owned grains
        std::uint32_t ghost_first = 0, ghost_last = 0; // into ghost_order
        std::uint32_t id = 0, ghost_id = 0;            // tile-local ids of the first, before compression
        Vec3d shift{0, 0, 0};
        bool exists = false;
    };
    /// The grains of a brick of cells and of one layer around it, cell after cell: cells that follow each other along z stand together.
    /// A search looks at eight grains at a time in single precision, with room for its rounding, then at those found in double.
    struct Grains {
        struct Exact {
            double x, y, z, radius; // m, images shifted to where they are near
            Label label;
            TileLocal id; // before compression
        };
        std::vector<std::uint32_t> first; // [cells + 1]
        std::vector<float> x, y, z, radius; // from a point of the brick, radii rounded up; may be read to seven places behind the end
        std::vector<Exact> exact;
        float rounding = 0.0f; // m, of distances between them

        std::uint32_t count() const { return first.back(); }
        /// Make room for the grains that `first` counts.
        void resize();
        void set(std::uint32_t k, const Particle& p, TileLocal grain, const Vec3d& shift, const Vec3d& base);
    };
    std::vector<Cell> cells;
    Grains owned, ghosts;
    std::vector<std::uint32_t> order;
    std::vector<LocalIndex> shell; // particles with ids beyond the own ones, before compression
    std::vector<TileLocal> new_id;
    std::vector<std::uint32_t> found;
    std::size_t n_pairs = 0;
    NearPairs near;
};

/// Find the near pairs of a tile, in scratch.near, and its border; sums are sized. The tile's index, first and count must be set.
void build_candidates(const CandidateSource& source, Tile& tile, CandidateScratch& scratch);

/// Tell every tile which border rows elsewhere belong to its grains. After all tiles are built.
void link_borders(std::vector<Tile>& tiles);

/// Adjacent tiles of each tile: those that one step or none along every axis leads to. Once per grid.
void link_neighbours(const CellOrder& order, std::vector<Tile>& tiles);

} // namespace talus::core
