// core/cells.hpp: a rank's grid of cells, grouped into tiles (bricks of cells), and the tile-major order of its grains.
//
// Cells are at least as wide as the reach of a candidate pair, so partners lie in adjacent cells. An axis is either open
// (grains beyond its ends fall into the end cells, which keeps neighbours adjacent) or wraps (a periodic axis that the rank
// owns whole). One, two and three cells on a wrapping axis each give every pair once: neighbours are found as cell + offset
// with an explicit image shift, and only one image of a pair lies within reach when the period is at least twice that.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/domain.hpp"

namespace talus::core {

struct CellGrid {
    double origin[3] = {0, 0, 0};
    double inverse_width[3] = {1, 1, 1}; // 1/m
    double period[3] = {0, 0, 0};        // m, on wrapping axes
    bool wraps[3] = {false, false, false};
    int cells[3] = {1, 1, 1};
    int tiles[3] = {1, 1, 1};

    bool operator==(const CellGrid&) const = default;

    int n_tiles() const { return tiles[0] * tiles[1] * tiles[2]; }
    std::uint32_t n_cells() const { return static_cast<std::uint32_t>(cells[0]) * cells[1] * cells[2]; }
    /// First cell of tile index t along an axis; t = tiles gives the end.
    int tile_begin(int axis, int t) const { return static_cast<int>(static_cast<std::int64_t>(t) * cells[axis] / tiles[axis]); }
    int tile_of_cell(int axis, int c) const {
        return static_cast<int>(((static_cast<std::int64_t>(c) + 1) * tiles[axis] - 1) / cells[axis]);
    }
    int cell_along(int axis, double x) const {
        const double c = (x - origin[axis]) * inverse_width[axis];
        // Clamped as a double: far away coordinates must not overflow the integer.
        return c <= 0.0 ? 0 : c >= cells[axis] ? cells[axis] - 1 : static_cast<int>(c);
    }
};

/// A cell's place in tile-major order: tiles in x, y, z order, cells within a tile likewise.
struct CellOrder {
    explicit CellOrder(const CellGrid& grid);
    CellOrder() = default;

    CellGrid grid;
    std::vector<std::uint32_t> first_of_tile; // [n_tiles + 1] rank of a tile's first cell

    /// Where a cell lies on one axis: its tile, and its place among the tile's cells.
    struct Along {
        int tile, offset, extent;
    };
    Along along(int axis, int c) const {
        const int t = grid.tile_of_cell(axis, c), base = grid.tile_begin(axis, t);
        return {t, c - base, grid.tile_begin(axis, t + 1) - base};
    }
    std::uint32_t rank_of(const Along& x, const Along& y, const Along& z) const {
        return first_of_tile[tile_index(x.tile, y.tile, z.tile)] + static_cast<std::uint32_t>((x.offset * y.extent + y.offset) * z.extent + z.offset);
    }
    std::uint32_t rank_of(int cx, int cy, int cz) const { return rank_of(along(0, cx), along(1, cy), along(2, cz)); }
    std::uint32_t rank_of(const double* position) const {
        return rank_of(grid.cell_along(0, position[0]), grid.cell_along(1, position[1]), grid.cell_along(2, position[2]));
    }
    int tile_index(int tx, int ty, int tz) const { return (tx * grid.tiles[1] + ty) * grid.tiles[2] + tz; }
};

/// Choose cells and tiles for a rank.
/// @param lo, hi       box of its grains (and of ghosts near it)
/// @param reach        least cell width [m]: largest diameter + skin
/// @param wraps        periodic axes that the rank owns whole
/// @param n_grains     grains in the box
/// @param tile_grains  grains aimed at in a tile
CellGrid choose_grid(const Domain& domain, const double (&lo)[3], const double (&hi)[3], double reach, const bool (&wraps)[3],
                     std::size_t n_grains, std::size_t tile_grains);

/// Counting sort by cell rank; within a cell by `key` (labels), so that the order is a function of the grains alone.
/// @param cell        [n] cell rank of each item
/// @param out_first   [n_cells + 1] items before each cell
/// @param out_order   [n] items in order
template <class Key>
void sort_by_cell(std::span<const std::uint32_t> cell, std::uint32_t n_cells, Key key, std::vector<std::uint32_t>& out_first,
                  std::vector<std::uint32_t>& out_order);

// ---- implementation ----

template <class Key>
void sort_by_cell(std::span<const std::uint32_t> cell, std::uint32_t n_cells, Key key, std::vector<std::uint32_t>& out_first,
                  std::vector<std::uint32_t>& out_order) {
    out_first.assign(static_cast<std::size_t>(n_cells) + 2, 0);
    // Counts two places on, so that scattering with first[cell + 1]++ leaves first[cell] right and needs no second array.
    for (const std::uint32_t c : cell) ++out_first[c + 2];
    for (std::size_t c = 2; c < out_first.size(); ++c) out_first[c] += out_first[c - 1];
    out_order.resize(cell.size());
    for (std::uint32_t i = 0; i < cell.size(); ++i) out_order[out_first[cell[i] + 1]++] = i;
    // Cells hold a few grains: insertion sort.
    for (std::uint32_t c = 0; c < n_cells; ++c)
        for (std::uint32_t k = out_first[c] + 1; k < out_first[c + 1]; ++k) {
            const std::uint32_t item = out_order[k];
            const auto item_key = key(item);
            std::uint32_t at = k;
            for (; at > out_first[c] && key(out_order[at - 1]) > item_key; --at) out_order[at] = out_order[at - 1];
            out_order[at] = item;
        }
    out_first.pop_back();
}

} // namespace talus::core
