// integrate: the node that moves a tile, and the watch over the lists.
#include <cmath>

#include "runtime/phase/phases.hpp"

namespace talus::runtime {

using core::DisplacementBox;
using core::Tile;

void integrate_tile(EngineState& s, int t) {
    if (s.errors.severity() != 0) return;
    Tile& tile = s.sub.tiles[t];
    if (s.with_forces) core::collect_border(s.sub.tiles, tile);
    core::integrate_tile(s.integrate, s.sub.particles.data(), s.sub.references.data(), tile);
    if (s.integrate.begin && !tile.finite)
        s.errors.set(core::ErrorKind::unstable, fmt::format("step {}: a grain of rank {} has a position or velocity that is not finite; a smaller time step usually cures it", s.model.step + 1, s.comm->rank()));
}

SkinUse skin_use(const EngineState& s) {
    const Subdomain& sub = s.sub;
    const double skin = s.model.skin(), dt = s.model.settings.time_step;
    double now = 0.0, foreseen = 0.0; // squares of relative displacements
    const auto look = [&](DisplacementBox box, const DisplacementBox& other) {
        box.merge(other);
        now = std::max(now, box.relative_squared());
        foreseen = std::max(foreseen, box.foreseen_squared());
    };
    SkinUse use;
    for (std::size_t t = 0; t < sub.tiles.size(); ++t) {
        const Tile& tile = sub.tiles[t];
        if (tile.count == 0) continue;
        use.all.merge(tile.displacement);
        look(tile.displacement, tile.displacement);
        for (const int u : tile.neighbours)
            if (u > static_cast<int>(t)) look(tile.displacement, sub.tiles[u].displacement);
        for (const int c : tile.watched_chunks) look(tile.displacement, sub.chunk_displacement[c]);
        for (std::size_t w = 0; w < s.model.walls.size(); ++w) {
            // How far the plane came towards the unlisted grains, the worst grain of the tile taken.
            const Wall& wall = s.model.walls[w];
            const core::Vec3d& n = wall.plane.normal;
            const double plane = core::dot(wall.plane.point - wall.listed_point, n);
            const double plane_foreseen = plane + core::kForeseenSteps * dt * core::dot(wall.plane.velocity, n);
            const auto least = [&](const double* lo, const double* hi) {
                const double c[3] = {n.x, n.y, n.z};
                double sum = 0.0;
                for (int a = 0; a < 3; ++a) sum += std::min(c[a] * lo[a], c[a] * hi[a]);
                return sum;
            };
            const DisplacementBox& d = tile.displacement;
            use.now = std::max(use.now, (plane - least(d.lo, d.hi)) / tile.wall_clearance[w]);
            use.foreseen = std::max(use.foreseen, (plane_foreseen - least(d.foreseen_lo, d.foreseen_hi)) / tile.wall_clearance[w]);
        }
    }
    use.now = std::max(use.now, std::sqrt(now) / skin);
    use.foreseen = std::max({use.foreseen, use.now, std::sqrt(foreseen) / skin});
    return use;
}

} // namespace talus::runtime
