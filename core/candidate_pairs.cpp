#include "core/candidate_pairs.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "core/contact_lanes.hpp"

namespace talus::core {

namespace {

/// With room for the rounding of a few operations in single precision.
float round_up(double length) { return static_cast<float>(length * (1.0 + 1e-5)); }

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
void gather(const CandidateSource& s, const Brick& brick, CandidateScratch& scratch) {
    Vec3d base;
    double* const at[3] = {&base.x, &base.y, &base.z};
    for (int a = 0; a < 3; ++a) *at[a] = s.order.grid.origin[a] + (brick.base[a] + 0.5 * brick.extent[a]) / s.order.grid.inverse_width[a];
    const auto copy = [&](CandidateScratch::Grains& to, auto first_of, auto last_of, auto set) {
        to.first.clear();
        std::uint32_t n = 0;
        for (const Cell& c : scratch.cells) {
            to.first.push_back(n);
            n += last_of(c) - first_of(c);
        }
        to.first.push_back(n);
        to.resize();
        std::uint32_t k = 0;
        for (const Cell& c : scratch.cells)
            for (std::uint32_t g = first_of(c); g < last_of(c); ++g) set(c, g, k++);
    };
    copy(
        scratch.owned, [](const Cell& c) { return c.first; }, [](const Cell& c) { return c.last; },
        [&](const Cell& c, std::uint32_t g, std::uint32_t k) { scratch.owned.set(k, s.particles[g], c.id + (g - c.first), c.shift, base); });
    copy(
        scratch.ghosts, [](const Cell& c) { return c.ghost_first; }, [](const Cell& c) { return c.ghost_last; },
        [&](const Cell& c, std::uint32_t g, std::uint32_t k) {
            const std::uint32_t ghost = s.ghost_order[g];
            scratch.ghosts.set(k, s.particles[s.n_owned + ghost], c.ghost_id + (g - c.ghost_first), s.ghost_shift[ghost] + c.shift, base);
        });
}

/// For every byte the places of its set bits, first to last.
constexpr auto kPlaces = [] {
    std::array<std::array<std::uint8_t, 8>, 256> places{};
    for (std::size_t bits = 0; bits < 256; ++bits)
        for (std::uint8_t k = 0, n = 0; k < 8; ++k)
            if ((bits >> k & 1) != 0) places[bits][n++] = k;
    return places;
}();

/// Append to `found` those of the grains [from, to) that may be within reach of grain g. No branch on what is found: half of what is
/// looked at is, and a processor guesses badly. @return their new number
std::size_t look_near(const CandidateScratch::Grains& all, std::uint32_t from, std::uint32_t to, const CandidateScratch::Grains& grains, std::uint32_t g, float reach, std::size_t n, std::vector<std::uint32_t>& found) {
    if (n + (to - from) + 8 > found.size()) found.resize(2 * (n + (to - from) + 8));
    const F8 gx = F8{} + grains.x[g], gy = F8{} + grains.y[g], gz = F8{} + grains.z[g], near_g = F8{} + reach;
    for (std::uint32_t k = from; k < to; k += 8) {
        const F8 dx = gx - load_any(&all.x[k]), dy = gy - load_any(&all.y[k]), dz = gz - load_any(&all.z[k]), near = near_g + load_any(&all.radius[k]);
        unsigned bits = bits_of_words(Word8(dx * dx + dy * dy + dz * dz < near * near));
        if (to - k < 8) bits &= (1u << (to - k)) - 1u;
        const __m256i places = _mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(kPlaces[bits].data())));
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(found.data() + n), _mm256_add_epi32(places, _mm256_set1_epi32(static_cast<int>(k))));
        n += static_cast<std::size_t>(std::popcount(bits));
    }
    return n;
}

/// List those of the n found whose surfaces are nearer to that of grain g than the skin.
void list_near(const CandidateScratch::Grains& all, const CandidateScratch::Grains& grains, std::uint32_t g, double skin, std::size_t n, CandidateScratch& scratch) {
    std::vector<CandidatePair>& pairs = scratch.near.of_grains;
    if (scratch.n_pairs + n > pairs.size()) pairs.resize(2 * (scratch.n_pairs + n));
    const auto& a = grains.exact[g];
    CandidatePair* to = pairs.data() + scratch.n_pairs;
    for (std::size_t f = 0; f < n; ++f) {
        const auto& b = all.exact[scratch.found[f]];
        const double dx = a.x - b.x, dy = a.y - b.y, dz = a.z - b.z, near = a.radius + skin + b.radius;
        if (!(dx * dx + dy * dy + dz * dz < near * near)) [[unlikely]] continue;
        const bool in_order = a.label < b.label;
        *to++ = {in_order ? a.id : b.id, in_order ? b.id : a.id};
    }
    scratch.n_pairs = static_cast<std::size_t>(to - pairs.data());
}

/// Drop the shell grains that no pair uses and renumber the rest.
void compress_border(const CandidateSource& s, Tile& tile, CandidateScratch& scratch) {
    constexpr TileLocal kUnused = 0xffffffffu;
    auto& new_id = scratch.new_id;
    new_id.assign(scratch.shell.size(), kUnused);
    for (const CandidatePair& p : scratch.near.of_grains)
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
    for (CandidatePair& p : scratch.near.of_grains) {
        TileLocal& partner = p.i > p.j ? p.i : p.j;
        if (partner >= tile.count) partner = new_id[partner - tile.count];
    }
}

void find_near_walls(const CandidateSource& s, Tile& tile, std::vector<std::vector<CandidatePair>>& near) {
    near.resize(s.walls.size());
    for (std::size_t w = 0; w < s.walls.size(); ++w) {
        const WallPlane& wall = s.walls[w];
        near[w].clear();
        double clearance = std::numeric_limits<double>::infinity();
        for (TileLocal k = 0; k < tile.count; ++k) {
            const Particle& p = s.particles[tile.first + k];
            const double gap = height_above<double>(wall.point, wall.normal, make_vec3(p.position)) - p.radius;
            if (gap < s.skin)
                near[w].push_back({k, k});
            else
                clearance = std::min(clearance, gap);
        }
        tile.wall_clearance[w] = clearance;
    }
}

} // namespace

void CandidateScratch::Grains::resize() {
    const std::size_t n = count();
    for (auto* column : {&x, &y, &z, &radius}) column->resize(n + 7);
    exact.resize(n);
    rounding = 0.0f;
}

void CandidateScratch::Grains::set(std::uint32_t k, const Particle& p, TileLocal grain, const Vec3d& shift, const Vec3d& base) {
    const Exact& e = exact[k] = {p.position[0] + shift.x, p.position[1] + shift.y, p.position[2] + shift.z, p.radius, p.label, grain};
    x[k] = static_cast<float>(e.x - base.x);
    y[k] = static_cast<float>(e.y - base.y);
    z[k] = static_cast<float>(e.z - base.z);
    radius[k] = round_up(p.radius);
    // Two grains are each off by half a unit in the last place of the larger, on three axes.
    rounding = std::max(rounding, 2.5e-7f * (std::fabs(x[k]) + std::fabs(y[k]) + std::fabs(z[k])));
}

void build_candidates(const CandidateSource& s, Tile& tile, CandidateScratch& scratch) {
    Brick brick;
    for (int a = 0; a < 3; ++a) {
        brick.base[a] = s.order.grid.tile_begin(a, tile.index[a]);
        brick.extent[a] = s.order.grid.tile_begin(a, tile.index[a] + 1) - brick.base[a];
    }
    look_up_cells(s, brick, scratch.cells);
    number_shell(s, tile, scratch);

    gather(s, brick, scratch);
    scratch.n_pairs = 0;
    const CandidateScratch::Grains &owned = scratch.owned, &ghosts = scratch.ghosts;
    const float skin = round_up(s.skin);
    const auto runs = [&](const CandidateScratch::Grains& all, int x, int y, int z) { return std::pair{all.first[brick.at(x, y, z - 1)], all.first[brick.at(x, y, z + 1) + 1]}; };
    for (int x = 0; x < brick.extent[0]; ++x)
        for (int y = 0; y < brick.extent[1]; ++y)
            for (int z = 0; z < brick.extent[2]; ++z)
                for (std::uint32_t g = owned.first[brick.at(x, y, z)]; g < owned.first[brick.at(x, y, z) + 1]; ++g) {
                    const auto reach = [&](const CandidateScratch::Grains& all) { return owned.radius[g] + skin + std::max(owned.rounding, all.rounding); };
                    // Each pair of cells is searched from one of them; ghosts search nobody, so all around are looked at.
                    std::size_t n = look_near(owned, g + 1, owned.first[brick.at(x, y, z + 1) + 1], owned, g, reach(owned), 0, scratch.found);
                    for (const auto& [dx, dy] : {std::pair{0, 1}, {1, -1}, {1, 0}, {1, 1}}) {
                        const auto [from, to] = runs(owned, x + dx, y + dy, z);
                        n = look_near(owned, from, to, owned, g, reach(owned), n, scratch.found);
                    }
                    list_near(owned, owned, g, s.skin, n, scratch);
                    if (ghosts.count() == 0) continue;
                    n = 0;
                    for (int dx = -1; dx <= 1; ++dx)
                        for (int dy = -1; dy <= 1; ++dy) {
                            const auto [from, to] = runs(ghosts, x + dx, y + dy, z);
                            n = look_near(ghosts, from, to, owned, g, reach(ghosts), n, scratch.found);
                        }
                    list_near(ghosts, owned, g, s.skin, n, scratch);
                }
    scratch.near.of_grains.resize(scratch.n_pairs);
    compress_border(s, tile, scratch);
    find_near_walls(s, tile, scratch.near.with_walls);
    resize_tightly(tile.sums, tile.index_of.size());
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

namespace {

/// The tiles beside each along an axis, through wraps too; empty where the axis has one tile.
std::vector<std::vector<int>> tiles_beside(const CellOrder& order, int axis) {
    const CellGrid& g = order.grid;
    if (g.tiles[axis] == 1) return {};
    std::vector<std::vector<int>> beside(static_cast<std::size_t>(g.n_tiles()));
    int c[3];
    for (c[0] = 0; c[0] < g.tiles[0]; ++c[0])
        for (c[1] = 0; c[1] < g.tiles[1]; ++c[1])
            for (c[2] = 0; c[2] < g.tiles[2]; ++c[2]) {
                auto& mine = beside[static_cast<std::size_t>(order.tile_index(c[0], c[1], c[2]))];
                for (const int step : {-1, 1}) {
                    int n[3] = {c[0], c[1], c[2]};
                    n[axis] += step;
                    if (g.wraps[axis]) n[axis] = (n[axis] + g.tiles[axis]) % g.tiles[axis];
                    if (n[axis] < 0 || n[axis] >= g.tiles[axis]) continue;
                    // Of two tiles on a wrapping axis each is beside the other once.
                    const int t = order.tile_index(n[0], n[1], n[2]);
                    if (mine.empty() || mine.back() != t) mine.push_back(t);
                }
            }
    return beside;
}

} // namespace

void link_neighbours(const CellOrder& order, std::vector<Tile>& tiles) {
    for (std::size_t t = 0; t < tiles.size(); ++t) tiles[t].neighbours = {static_cast<int>(t)};
    for (int axis = 0; axis < 3; ++axis) {
        const auto beside = tiles_beside(order, axis);
        if (beside.empty()) continue;
        for (Tile& tile : tiles) {
            const std::vector<int> reached = tile.neighbours;
            for (const int u : reached) tile.neighbours.insert(tile.neighbours.end(), beside[static_cast<std::size_t>(u)].begin(), beside[static_cast<std::size_t>(u)].end());
        }
    }
    for (std::size_t t = 0; t < tiles.size(); ++t) {
        auto& all = tiles[t].neighbours;
        std::sort(all.begin(), all.end());
        all.erase(std::unique(all.begin(), all.end()), all.end());
        std::erase(all, static_cast<int>(t));
    }
}

} // namespace talus::core
