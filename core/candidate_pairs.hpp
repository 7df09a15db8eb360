// core/candidate_pairs.hpp: the pairs of grains near enough to touch before the next rebuild, found through cells.
//
// A pair is listed when the gap between two surfaces is below the skin. Each pair of owned grains stands once, in the tile of
// one of them; a pair with a ghost stands on both ranks. Which images are near is decided here, with explicit shifts; the
// kernel then takes the minimum image, which is the same one since periods are at least twice the reach.
#pragma once

#include <bit>
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
    /// The grains of a brick of cells and of one layer around it, cell after cell, as columns: cells that follow each other along z
    /// stand together, and are searched four grains at a time.
    struct Grains {
        std::vector<std::uint32_t> first; // [cells + 1]
        std::vector<double> x, y, z, radius; // m, images shifted to where they are near
        std::vector<TileLocal> id;           // before compression
        std::vector<Label> label;

        void clear() {
            first.clear();
            for (auto* column : {&x, &y, &z, &radius}) column->clear();
            id.clear();
            label.clear();
        }
        void begin_cell() { first.push_back(static_cast<std::uint32_t>(id.size())); }
        void add(const Particle& p, TileLocal grain, const Vec3d& shift) {
            x.push_back(p.position[0] + shift.x);
            y.push_back(p.position[1] + shift.y);
            z.push_back(p.position[2] + shift.z);
            radius.push_back(p.radius);
            id.push_back(grain);
            label.push_back(p.label);
        }
        /// Columns may be read to three places behind their ends.
        void close() {
            begin_cell();
            for (auto* column : {&x, &y, &z, &radius}) column->resize(column->size() + 3);
        }
        /// visit(k) for each in [from, to) whose surface is nearer than `skin` to that of grain g of `grains`.
        template <class Visit>
        void each_near(std::uint32_t from, std::uint32_t to, const Grains& grains, std::uint32_t g, double skin, Visit visit) const {
            const V4 gx = splat<V4>(grains.x[g]), gy = splat<V4>(grains.y[g]), gz = splat<V4>(grains.z[g]), reach = splat<V4>(grains.radius[g] + skin);
            for (std::uint32_t k = from; k < to; k += 4) {
                const V4 dx = gx - load_any(&x[k]), dy = gy - load_any(&y[k]), dz = gz - load_any(&z[k]), near = reach + load_any(&radius[k]);
                unsigned bits = bits_of(dx * dx + dy * dy + dz * dz < near * near);
                if (to - k < 4) bits &= (1u << (to - k)) - 1u;
                for (; bits != 0; bits &= bits - 1) visit(k + static_cast<std::uint32_t>(std::countr_zero(bits)));
            }
        }
    };
    std::vector<Cell> cells;
    Grains owned, ghosts;
    std::vector<std::uint32_t> order;
    std::vector<LocalIndex> shell; // particles with ids beyond the own ones, before compression
    std::vector<TileLocal> new_id;
    std::vector<CandidatePair> pairs;
};

/// Build a tile's lists of candidates, its border and its wall lists, without contacts; sums are sized and cleared.
/// The tile's index, first and count must be set.
void build_candidates(const CandidateSource& source, int history_doubles, Tile& tile, CandidateScratch& scratch);

/// Tell every tile which border rows elsewhere belong to its grains. After all tiles are built.
void link_borders(std::vector<Tile>& tiles);

/// Adjacent tiles of each tile, through wraps too. Once per grid.
void link_neighbours(const CellOrder& order, std::vector<Tile>& tiles);

} // namespace talus::core
