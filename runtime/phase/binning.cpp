// binning: owned grains in tile-major order.
#include <cmath>

#include "runtime/phase/phases.hpp"

namespace talus::runtime {

using core::Particle;

namespace {

constexpr int kBlock = 4096; // grains a task

template <class Body>
void for_blocks(EngineState& s, std::size_t n, Body body) {
    const int blocks = static_cast<int>((n + kBlock - 1) / kBlock);
    s.workers.for_each(Phase::binning, blocks, [&](int b) {
        const std::size_t first = static_cast<std::size_t>(b) * kBlock;
        for (std::size_t i = first; i < std::min(n, first + kBlock); ++i) body(static_cast<std::uint32_t>(i));
    });
}

template <class T>
void permute(EngineState& s, std::vector<T>& items, const std::vector<std::uint32_t>& order) {
    std::vector<T> sorted(items.size());
    for_blocks(s, order.size(), [&](std::uint32_t i) { sorted[i] = items[order[i]]; });
    items.swap(sorted);
}

void check_inside(const EngineState& s, const Particle& p) {
    const core::Domain& d = s.model.settings.domain;
    for (int a = 0; a < 3; ++a) {
        const double x = p.position[a];
        if (!std::isfinite(x) || !std::isfinite(p.velocity[a]) || !std::isfinite(p.angular_velocity[a]))
            core::fail(core::ErrorKind::unstable, "step {}: grain {} is not finite: position {} {} {}, velocity {} {} {} (rank {}); a smaller time step usually cures it", s.model.step, p.label, p.position[0],
                       p.position[1], p.position[2], p.velocity[0], p.velocity[1], p.velocity[2], s.comm->rank());
        if (!d.periodic[a] && (x < d.lo[a] || x > d.hi[a]))
            core::fail(core::ErrorKind::lost, "step {}: grain {} left the domain on axis {}: position {} {} {}, velocity {} {} {}, last owner rank {}; the domain there is {} to {}. Close it with a wall or make it larger",
                       s.model.step, p.label, "xyz"[a], p.position[0], p.position[1], p.position[2], p.velocity[0], p.velocity[1], p.velocity[2], s.comm->rank(), d.lo[a], d.hi[a]);
    }
}

core::CellGrid grid_for(const EngineState& s) {
    const Subdomain& sub = s.sub;
    const core::Domain& d = s.model.settings.domain;
    const double reach = s.model.reach();
    double lo[3], hi[3];
    bool wraps[3];
    const core::Box mine = s.slices.box(s.comm->rank());
    for (int a = 0; a < 3; ++a) {
        lo[a] = sub.n_owned > 0 ? HUGE_VAL : d.lo[a];
        hi[a] = sub.n_owned > 0 ? -HUGE_VAL : d.lo[a];
        for (core::LocalIndex i = 0; i < sub.n_owned; ++i) {
            lo[a] = std::min(lo[a], sub.particles[i].position[a]);
            hi[a] = std::max(hi[a], sub.particles[i].position[a]);
        }
        wraps[a] = d.periodic[a] && s.slices.grid()[a] == 1;
        // Room for ghosts where the subdomain is cut.
        if (std::isfinite(mine.lo[a]) || (d.periodic[a] && !wraps[a])) lo[a] -= reach;
        if (std::isfinite(mine.hi[a]) || (d.periodic[a] && !wraps[a])) hi[a] += reach;
    }
    const int aim = s.model.settings.tile_grains > 0 ? s.model.settings.tile_grains : kDefaultTileGrains;
    return core::choose_grid(d, lo, hi, reach, wraps, sub.n_owned, static_cast<std::size_t>(aim));
}

} // namespace

void bin_grains(EngineState& s) {
    Subdomain& sub = s.sub;
    for (core::LocalIndex i = 0; i < sub.n_owned; ++i) check_inside(s, sub.particles[i]);
    sub.order = core::CellOrder(grid_for(s));

    std::vector<std::uint32_t> cell(sub.n_owned), order;
    for_blocks(s, sub.n_owned, [&](std::uint32_t i) { cell[i] = sub.order.rank_of(sub.particles[i].position); });
    s.workers.timed(Phase::binning, 0, [&] {
        core::sort_by_cell(std::span<const std::uint32_t>(cell), sub.order.grid.n_cells(), [&](std::uint32_t i) { return sub.particles[i].label; }, sub.cell_first, order);
    });
    permute(s, sub.particles, order);
    permute(s, sub.references, order);
    permute(s, sub.sums, order);
    permute(s, sub.slot_of, order);

    const core::CellGrid& grid = sub.order.grid;
    sub.tiles.resize(static_cast<std::size_t>(grid.n_tiles()));
    int t = 0;
    for (int x = 0; x < grid.tiles[0]; ++x)
        for (int y = 0; y < grid.tiles[1]; ++y)
            for (int z = 0; z < grid.tiles[2]; ++z, ++t) {
                core::Tile& tile = sub.tiles[t];
                tile.index[0] = x;
                tile.index[1] = y;
                tile.index[2] = z;
                tile.first = sub.cell_first[sub.order.first_of_tile[t]];
                tile.count = sub.cell_first[sub.order.first_of_tile[t + 1]] - tile.first;
            }
    core::link_neighbours(sub.order, sub.tiles);
}

} // namespace talus::runtime
