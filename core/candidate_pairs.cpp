#include "core/candidate_pairs.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/contact_lanes.hpp"

namespace talus::core {

namespace {

using Cell = CandidateScratch::Cell;

/// A tile's brick of cells with one layer around it.
struct Brick {
    int base[3], extent[3];

    int at(int x, int y, int z) const { return ((x + 1) * (extent[1] + 2) + (y + 1)) * (extent[2] + 2) + (z + 1); }
    int size() const { return (extent[0] + 2) * (extent[1] + 2) * (extent[2] + 2); }
};

void look_up_cells(const CandidateSource& s, const Brick& brick, std::vector<Cell>& cells) {
    const CellGrid& grid = s.order.grid;
    struct Place {
        CellOrder::Along along;
        double shift;
        bool exists;
    };
    std::vector<Place> places[3];
    for (int a = 0; a < 3; ++a)
        for (int k = -1; k <= brick.extent[a]; ++k) {
            int c = brick.base[a] + k;
            const bool inside = c >= 0 && c < grid.cells[a];
            const double shift = inside ? 0.0 : c < 0 ? -grid.period[a] : grid.period[a];
            if (!inside) c += c < 0 ? grid.cells[a] : -grid.cells[a];
            const bool exists = inside || grid.wraps[a];
            places[a].push_back({exists ? s.order.along(a, c) : CellOrder::Along{}, shift, exists});
        }
    cells.assign(static_cast<std::size_t>(brick.size()), Cell{});
    Cell* cell = cells.data();
    for (const Place& x : places[0])
        for (const Place& y : places[1])
            for (const Place& z : places[2]) {
                Cell& c = *cell++;
                if (!x.exists || !y.exists || !z.exists) continue;
                c.exists = true;
                c.shift = {x.shift, y.shift, z.shift};
                c.rank = s.order.rank_of(x.along, y.along, z.along);
                c.first = s.cell_first[c.rank];
                c.last = s.cell_first[c.rank + 1];
                if (!s.ghost_first.empty()) {
                    c.ghost_first = s.ghost_first[c.rank];
                    c.ghost_last = s.ghost_first[c.rank + 1];
                }
            }
}

/// Number the grains around the brick in the order of their local index, owned ones first, so that the border rows of each
/// other tile stand together.
void number_shell(const CandidateSource& s, const Tile& tile, CandidateScratch& scratch) {
    auto& cells = scratch.cells;
    auto& order = scratch.order;
    order.clear();
    for (std::uint32_t k = 0; k < cells.size(); ++k)
        if (cells[k].exists) order.push_back(k);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return cells[a].rank < cells[b].rank; });

    scratch.shell.clear();
    const LocalIndex own_last = tile.first + tile.count;
    const auto next_id = [&] { return tile.count + static_cast<TileLocal>(scratch.shell.size()); };
    // A cell seen twice, through a wrap, gets the same ids.
    const Cell* before = nullptr;
    for (const std::uint32_t k : order) {
        Cell& cell = cells[k];
        if (cell.first < cell.last && cell.first >= tile.first && cell.last <= own_last) {
            cell.id = cell.first - tile.first;
        } else if (before != nullptr && before->rank == cell.rank) {
            cell.id = before->id;
        } else {
            before = &cell;
            cell.id = next_id();
            for (std::uint32_t g = cell.first; g < cell.last; ++g) scratch.shell.push_back(g);
        }
    }
    before = nullptr;
    for (const std::uint32_t k : order) {
        Cell& cell = cells[k];
        if (before != nullptr && before->rank == cell.rank) {
            cell.ghost_id = before->ghost_id;
        } else {
            before = &cell;
            cell.ghost_id = next_id();
            for (std::uint32_t g = cell.ghost_first; g < cell.ghost_last; ++g) scratch.shell.push_back(s.n_owned + s.ghost_order[g]);
        }
    }
}

/// Copy what the search reads of the brick and the layer around it.
void gather(const CandidateSource& s, CandidateScratch& scratch) {
    scratch.owned.clear();
    scratch.ghosts.clear();
    for (const Cell& c : scratch.cells) {
        scratch.owned.begin_cell();
        for (std::uint32_t g = c.first; g < c.last; ++g) scratch.owned.add(s.particles[g], c.id + (g - c.first), c.shift);
        scratch.ghosts.begin_cell();
        for (std::uint32_t g = c.ghost_first; g < c.ghost_last; ++g) scratch.ghosts.add(s.particles[s.n_owned + s.ghost_order[g]], c.ghost_id + (g - c.ghost_first), s.ghost_shift[s.ghost_order[g]] + c.shift);
    }
    scratch.owned.close();
    scratch.ghosts.close();
}

/// Drop the shell grains that no pair uses and renumber the rest.
void compress_border(const CandidateSource& s, Tile& tile, CandidateScratch& scratch) {
    constexpr TileLocal kUnused = 0xffffffffu;
    auto& new_id = scratch.new_id;
    new_id.assign(scratch.shell.size(), kUnused);
    for (const CandidatePair& p : scratch.pairs)
        if (p.partner() >= tile.count) new_id[p.partner() - tile.count] = 0;
    tile.index_of.resize(tile.count);
    for (std::uint32_t k = 0; k < tile.count; ++k) tile.index_of[k] = tile.first + k;
    tile.n_border = 0;
    tile.ghost_chunks.clear();
    for (std::size_t k = 0; k < new_id.size(); ++k) {
        if (new_id[k] == kUnused) continue;
        new_id[k] = static_cast<TileLocal>(tile.index_of.size());
        const LocalIndex p = scratch.shell[k];
        tile.index_of.push_back(p);
        if (p < s.n_owned)
            ++tile.n_border;
        else
            tile.ghost_chunks.push_back(s.ghost_chunk[p - s.n_owned]);
    }
    std::sort(tile.ghost_chunks.begin(), tile.ghost_chunks.end());
    tile.ghost_chunks.erase(std::unique(tile.ghost_chunks.begin(), tile.ghost_chunks.end()), tile.ghost_chunks.end());
    for (CandidatePair& p : scratch.pairs) {
        TileLocal& partner = p.i > p.j ? p.i : p.j;
        if (partner >= tile.count) partner = new_id[partner - tile.count];
    }
}

void list_walls(const CandidateSource& s, int history_doubles, Tile& tile, std::vector<CandidatePair>& pairs) {
    tile.walls.resize(s.walls.size());
    for (std::size_t w = 0; w < s.walls.size(); ++w) {
        const WallPlane& wall = s.walls[w];
        pairs.clear();
        double clearance = std::numeric_limits<double>::infinity();
        for (TileLocal k = 0; k < tile.count; ++k) {
            const Particle& p = s.particles[tile.first + k];
            const double gap = height_above<double>(wall.point, wall.normal, make_vec3(p.position)) - p.radius;
            if (gap < s.skin)
                pairs.push_back({k, k});
            else
                clearance = std::min(clearance, gap);
        }
        tile.wall_clearance[w] = clearance;
        tile.walls[w].start(history_doubles);
        tile.walls[w].set_candidates(pairs);
    }
}

} // namespace

void build_candidates(const CandidateSource& s, int history_doubles, Tile& tile, CandidateScratch& scratch) {
    Brick brick;
    for (int a = 0; a < 3; ++a) {
        brick.base[a] = s.order.grid.tile_begin(a, tile.index[a]);
        brick.extent[a] = s.order.grid.tile_begin(a, tile.index[a] + 1) - brick.base[a];
    }
    look_up_cells(s, brick, scratch.cells);
    number_shell(s, tile, scratch);

    gather(s, scratch);
    auto& pairs = scratch.pairs;
    pairs.clear();
    const CandidateScratch::Grains &owned = scratch.owned, &ghosts = scratch.ghosts;
    const auto list = [&](std::uint32_t g, const CandidateScratch::Grains& others, std::uint32_t from, std::uint32_t to) {
        others.each_near(from, to, owned, g, s.skin, [&](std::uint32_t k) {
            pairs.push_back(owned.label[g] < others.label[k] ? CandidatePair{owned.id[g], others.id[k]} : CandidatePair{others.id[k], owned.id[g]});
        });
    };
    for (int x = 0; x < brick.extent[0]; ++x)
        for (int y = 0; y < brick.extent[1]; ++y)
            for (int z = 0; z < brick.extent[2]; ++z)
                for (std::uint32_t g = owned.first[brick.at(x, y, z)]; g < owned.first[brick.at(x, y, z) + 1]; ++g) {
                    // Each pair of cells is searched from one of them; ghosts search nobody, so all around are looked at.
                    list(g, owned, g + 1, owned.first[brick.at(x, y, z + 1) + 1]);
                    for (const auto& [dx, dy] : {std::pair{0, 1}, {1, -1}, {1, 0}, {1, 1}}) list(g, owned, owned.first[brick.at(x + dx, y + dy, z - 1)], owned.first[brick.at(x + dx, y + dy, z + 1) + 1]);
                    if (ghosts.id.empty()) continue;
                    for (int dx = -1; dx <= 1; ++dx)
                        for (int dy = -1; dy <= 1; ++dy) list(g, ghosts, ghosts.first[brick.at(x + dx, y + dy, z - 1)], ghosts.first[brick.at(x + dx, y + dy, z + 1) + 1]);
                }
    compress_border(s, tile, scratch);
    tile.pairs.start(history_doubles);
    tile.pairs.set_candidates(pairs);
    list_walls(s, history_doubles, tile, pairs);
    tile.sums.assign(tile.index_of.size(), ForceSum{});
    tile.wall_sums.assign(s.walls.size(), WallSum{});
}

void link_borders(std::vector<Tile>& tiles) {
    for (Tile& t : tiles) t.incoming.clear();
    for (std::size_t t = 0; t < tiles.size(); ++t) {
        const Tile& tile = tiles[t];
        TileLocal id = tile.count;
        const TileLocal end = tile.count + tile.n_border;
        while (id < end) {
            const LocalIndex p = tile.index_of[id];
            auto owner = std::upper_bound(tiles.begin(), tiles.end(), p, [](LocalIndex v, const Tile& u) { return v < u.first + u.count; });
            TileLocal last = id;
            while (last < end && tile.index_of[last] < owner->first + owner->count) ++last;
            owner->incoming.push_back({static_cast<int>(t), id, last - id});
            id = last;
        }
    }
}

void link_neighbours(const CellOrder& order, std::vector<Tile>& tiles) {
    const CellGrid& g = order.grid;
    for (int t = 0; t < g.n_tiles(); ++t) {
        Tile& tile = tiles[t];
        tile.neighbours.clear();
        for (int o = 0; o < 27; ++o) {
            int c[3] = {tile.index[0] + o / 9 - 1, tile.index[1] + o / 3 % 3 - 1, tile.index[2] + o % 3 - 1};
            bool exists = true;
            for (int a = 0; a < 3; ++a) {
                if (c[a] >= 0 && c[a] < g.tiles[a]) continue;
                exists = exists && g.wraps[a];
                c[a] = (c[a] + g.tiles[a]) % g.tiles[a];
            }
            if (!exists) continue;
            const int u = order.tile_index(c[0], c[1], c[2]);
            if (u != t) tile.neighbours.push_back(u);
        }
        std::sort(tile.neighbours.begin(), tile.neighbours.end());
        tile.neighbours.erase(std::unique(tile.neighbours.begin(), tile.neighbours.end()), tile.neighbours.end());
    }
}

} // namespace talus::core
