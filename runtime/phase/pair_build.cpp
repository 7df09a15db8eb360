// pair_build: candidate lists, and the inheritance of contact histories through them.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>

#include "runtime/phase/old_tiles.hpp"
#include "runtime/phase/phases.hpp"

namespace talus::runtime {

using core::LocalIndex;
using core::Tile;

namespace {

/// Make the store speak of a rank's tiles, not indexed yet.
void refer_to(EngineState& s, std::vector<Tile>& tiles, core::ContactStore& store) {
    const Subdomain& sub = s.sub;
    store.clear();
    store.history_doubles = core::history_doubles(s.model.settings.laws);
    store.tiles = tiles;
    store.n_grains = sub.n_owned;
    store.labels.resize(sub.particles.size());
    s.workers.for_each(Phase::pair_build, static_cast<int>(tiles.size()), [&](int t) {
        for (LocalIndex i = tiles[t].first; i < tiles[t].first + tiles[t].count; ++i) store.labels[i] = sub.particles[i].label;
        tiles[t].by_grain.first.clear();
    });
    for (std::size_t g = sub.n_owned; g < sub.particles.size(); ++g) store.labels[g] = sub.particles[g].label;
}

} // namespace

void lay_out_contacts(EngineState& s, core::ContactStore& store) {
    refer_to(s, s.sub.tiles, store);
    s.workers.for_each(Phase::pair_build, static_cast<int>(s.sub.tiles.size()), [&](int t) { core::index_contacts(store.labels, s.sub.tiles[t]); });
}

void empty_tiles(EngineState& s, bool keep_sums) {
    Subdomain& sub = s.sub;
    if (sub.laid_out) return;
    sub.laid_out = true;
    end_watch(s);
    sub.old_tiles.swap(sub.tiles);
    refer_to(s, sub.old_tiles, sub.contacts);
    sub.keeps_sums = keep_sums;
    sub.sums.resize(keep_sums ? sub.n_owned : 0);
    sub.slot_of.resize(sub.n_owned);
    s.workers.for_each(Phase::pair_build, static_cast<int>(sub.old_tiles.size()), [&](int t) {
        const Tile& tile = sub.old_tiles[t];
        for (std::uint32_t k = 0; k < tile.count; ++k) {
            if (keep_sums) sub.sums[tile.first + k] = tile.sums[k];
            sub.slot_of[tile.first + k] = tile.first + k;
        }
    });
    for (const Tile& tile : sub.old_tiles) {
        sub.heat.friction += tile.heat.friction;
        sub.heat.damping += tile.heat.damping;
        sub.heat.rolling += tile.heat.rolling;
    }
    // Ghosts are void from here.
    sub.particles.resize(sub.n_owned);
}

namespace {

void bin_ghosts(Subdomain& sub) {
    const LocalIndex n = sub.n_ghosts();
    if (n == 0) {
        sub.ghost_cell_first.clear();
        sub.ghost_order.clear();
        return;
    }
    std::vector<std::uint32_t> cell(n);
    for (LocalIndex g = 0; g < n; ++g) {
        const core::Particle& p = sub.particles[sub.n_owned + g];
        const core::Vec3d& shift = sub.ghost_shift[g];
        const double near[3] = {p.position[0] + shift.x, p.position[1] + shift.y, p.position[2] + shift.z};
        cell[g] = sub.order.rank_of(near);
    }
    core::sort_by_cell(std::span<const std::uint32_t>(cell), sub.order.grid.n_cells(), [&](std::uint32_t g) { return sub.particles[sub.n_owned + g].label; }, sub.ghost_cell_first, sub.ghost_order);
}

/// Chunks within twice the reach of a tile. Pairs with any other chunk start at least that far apart, as pairs of tiles that are not
/// neighbours do; the watch over all displacements together serves them (see Engine::agree_on_step).
void find_watched_chunks(const EngineState& s, Tile& tile) {
    tile.watched_chunks.clear();
    if (tile.count == 0 || s.sub.chunk_range.empty()) return;
    core::Box mine{{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
    for (LocalIndex i = tile.first; i < tile.first + tile.count; ++i)
        for (int a = 0; a < 3; ++a) {
            mine.lo[a] = std::min(mine.lo[a], s.sub.particles[i].position[a]);
            mine.hi[a] = std::max(mine.hi[a], s.sub.particles[i].position[a]);
        }
    const core::CellGrid& grid = s.sub.order.grid;
    const double distance = 2.0 * s.model.reach();
    for (std::size_t c = 0; c < s.sub.chunk_range.size(); ++c) {
        const core::Box& place = s.sub.chunk_range[c].place;
        bool near = true;
        for (int a = 0; a < 3; ++a) {
            bool on_axis = false;
            for (int image = grid.wraps[a] ? -1 : 0; image <= (grid.wraps[a] ? 1 : 0); ++image) {
                const double shift = image * grid.period[a];
                on_axis = on_axis || (place.lo[a] + shift < mine.hi[a] + distance && place.hi[a] + shift > mine.lo[a] - distance);
            }
            near = near && on_axis;
        }
        if (near) tile.watched_chunks.push_back(static_cast<int>(c));
    }
}

/// The tiles plane by plane along the axis with the most of them: old tiles are held for the fewest new ones then.
std::vector<int> plane_by_plane(const Subdomain& sub) {
    const int* tiles = sub.order.grid.tiles;
    const auto axis = std::max_element(tiles, tiles + 3) - tiles;
    std::vector<int> order(sub.tiles.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](int t, int u) { return sub.tiles[t].index[axis] < sub.tiles[u].index[axis]; });
    return order;
}

} // namespace

void build_pairs(EngineState& s) {
    Subdomain& sub = s.sub;
    const double foreseen_time = core::kForeseenSteps * s.model.settings.time_step;
    const auto mark = [&](core::Particle& p, core::DisplacementBox& box) {
        double foreseen[3];
        for (int a = 0; a < 3; ++a) {
            p.listed_position[a] = p.position[a];
            foreseen[a] = foreseen_time * p.velocity[a];
        }
        box.add({0.0, 0.0, 0.0}, foreseen);
    };
    s.workers.timed(Phase::pair_build, 0, [&] {
        bin_ghosts(sub);
        for (LocalIndex g = 0; g < sub.n_ghosts(); ++g) mark(sub.particles[sub.n_owned + g], sub.chunk_displacement[sub.ghost_chunk[g]]);
        for (std::size_t c = 0; c < sub.chunk_range.size(); ++c)
            for (const auto* v : {&sub.chunk_range[c].velocity.lo, &sub.chunk_range[c].velocity.hi})
                sub.chunk_displacement[c].add({0.0, 0.0, 0.0}, {foreseen_time * (*v)[0], foreseen_time * (*v)[1], foreseen_time * (*v)[2]});
    });
    std::vector<core::WallPlane> walls;
    for (Wall& w : s.model.walls) {
        w.listed_point = w.plane.point;
        walls.push_back(w.plane);
    }
    const core::CandidateSource source{sub.particles, sub.n_owned, sub.order, sub.cell_first, sub.ghost_cell_first, sub.ghost_order, sub.ghost_shift, sub.ghost_chunk, walls, s.model.skin()};
    OldTiles old(s);
    // Taken in order, whoever takes them, so that old tiles are soon done with.
    const std::vector<int> order = plane_by_plane(sub);
    std::atomic<std::size_t> next{0};
    s.workers.for_each(Phase::pair_build, static_cast<int>(sub.tiles.size()), [&](int) {
        const int t = order[next.fetch_add(1, std::memory_order_relaxed)];
        Tile& tile = sub.tiles[t];
        old.lend_memory(tile);
        core::CandidateScratch& scratch = s.candidate_scratch[Workers::current()];
        core::build_candidates(source, tile, scratch);
        old.open(t);
        core::inherit_histories(sub.contacts, sub.slot_of, sub.particles, scratch.near, tile, s.inherit_scratch[Workers::current()]);
        old.close(t);
        find_watched_chunks(s, tile);
        tile.displacement.clear();
        for (std::uint32_t k = 0; k < tile.count; ++k) {
            if (sub.keeps_sums) tile.sums[k] = sub.sums[tile.first + k];
            mark(sub.particles[tile.first + k], tile.displacement);
        }
    });
    s.workers.timed(Phase::pair_build, 0, [&] { core::link_borders(sub.tiles); });
    // What travelled is in the tiles now.
    sub.old_tiles.clear();
    sub.spare_tiles.resize(std::min(sub.spare_tiles.size(), sub.tiles.size()));
    sub.contacts.clear();
    sub.sums = std::vector<core::ForceSum>();
    sub.slot_of.clear();
    sub.laid_out = false;
}

} // namespace talus::runtime
