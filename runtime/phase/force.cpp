// force: the node of the step graph that evaluates a tile's contacts.
#include "runtime/phase/phases.hpp"

namespace talus::runtime {

using core::Tile;

void force_tile(EngineState& s, int t) {
    if (!s.with_forces || s.errors.severity() != 0) return;
    try {
        Tile& tile = s.sub.tiles[t];
        core::TileGrains& grains = s.tile_grains[Workers::current()];
        grains.gather(s.sub.particles.data(), tile.index_of);
        const core::TileForces work{{s.sub.particles.data(), s.sub.n_owned, tile.index_of.data()}, &grains, tile.sums.data()};
        std::fill(tile.sums.begin(), tile.sums.end(), core::ForceSum{});
        tile.breach = core::CapBreach{};
        s.kernels.pair(s.force, work, tile.pairs, tile.heat, tile.breach);
        for (std::size_t w = 0; w < tile.walls.size(); ++w) {
            tile.wall_sums[w] = core::WallSum{};
            s.kernels.wall(s.force, s.model.walls[w].plane, static_cast<int>(w), work, tile.walls[w], tile.wall_sums[w], tile.heat, tile.breach);
        }
        if (tile.breach.found) {
            const core::CapBreach& b = tile.breach;
            const std::string partner = b.j >= core::kWallLabel ? fmt::format("wall {}", b.j - core::kWallLabel) : fmt::format("grain {}", b.j);
            core::fail(core::ErrorKind::unstable, "step {}: grain {} and {} push each other with {} N: that force, or its torque over the largest radius, is above the cap of {} N (an overlap of a whole radius): the run is exploding; reduce the time step, or look for grains that started inside each other or inside a wall",
                       s.model.step + 1, b.i, partner, b.force, core::kCapUnits * s.model.units.force.unit);
        }
    } catch (const core::Error& e) {
        s.errors.set(e.kind(), e.what());
    } catch (const std::exception& e) {
        s.errors.set(core::ErrorKind::capacity, fmt::format("rank {}, force of tile {}: {}", s.comm->rank(), t, e.what()));
    }
}

} // namespace talus::runtime
