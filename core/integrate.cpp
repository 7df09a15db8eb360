#include "core/integrate.hpp"

#include <cmath>

namespace talus::core {

void collect_border(std::vector<Tile>& tiles, Tile& tile) {
    for (const IncomingSums& in : tile.incoming) {
        Tile& from = tiles[in.from_tile];
        for (TileLocal id = in.first; id < in.first + in.count; ++id) {
            tile.sums[from.index_of[id] - tile.first] += from.sums[id];
            from.sums[id] = ForceSum{};
        }
    }
}

namespace {

V4 load(const double* p) { return (V4)_mm256_load_pd(p); }
void store(double* p, V4 v) { _mm256_store_pd(p, (__m256d)v); }
V4 as_double(const std::int64_t (&n)[3]) {
    return V4{static_cast<double>(n[0]), static_cast<double>(n[1]), static_cast<double>(n[2]), 0.0};
}

} // namespace

void integrate_tile(const IntegrateContext& c, Particle* particles, Reference* references, Tile& tile) {
    const double half = 0.5 * c.dt;
    // The fourth lane of a row holds radius, mass or meta: its factor is zero, so it stays as it is.
    const V4 gravity_kick = V4{c.gravity[0], c.gravity[1], c.gravity[2], 0.0} * splat<V4>(half);
    const V4 drift{c.dt, c.dt, c.dt, 0.0};
    if (c.begin) {
        tile.displacement.clear();
        tile.finite = true;
    }
    for (std::uint32_t k = 0; k < tile.count; ++k) {
        Particle& p = particles[tile.first + k];
        ForceSum& sum = tile.sums[k];
        const GroupMotion& motion = c.groups[group_of(p)];
        if (motion.mode == GroupMotion::Mode::free) [[likely]] {
            V4 velocity = load(p.velocity);
            // Angular velocities are handled apart from meta, whose bits must not go through arithmetic.
            const double mass = p.mass;
            const V4 force = as_double(sum.force) * splat<V4>(c.units.force.unit);
            const V4 torque = as_double(sum.torque) * splat<V4>(c.units.torque.unit);
            const V4 kick = splat<V4>(half / mass);
            const V4 spin = splat<V4>(half / (kSphereInertia * mass * (p.radius * p.radius)));
            V4 turning{p.angular_velocity[0], p.angular_velocity[1], p.angular_velocity[2], 0.0};
            if (c.finish) {
                velocity = fma(force, kick, velocity) + gravity_kick;
                turning = fma(torque, spin, turning);
            }
            if (c.begin) {
                velocity = fma(force, kick, velocity) + gravity_kick;
                turning = fma(torque, spin, turning);
            }
            store(p.velocity, velocity);
            for (int a = 0; a < 3; ++a) p.angular_velocity[a] = turning[a];
        } else {
            const bool driven = motion.mode == GroupMotion::Mode::driven;
            for (int a = 0; a < 3; ++a) {
                p.velocity[a] = driven ? motion.velocity[a] : 0.0;
                p.angular_velocity[a] = driven ? motion.angular_velocity[a] : 0.0;
            }
        }
        if (!c.begin) continue;

        const V4 velocity = load(p.velocity);
        store(p.position, fma(velocity, drift, load(p.position)));
        wrap(c.domain, p.position, references[tile.first + k]);
        sum = ForceSum{};

        const Vec3d moved = minimum_image(c.periods, make_vec3(p.position) - make_vec3(p.listed_position));
        const double now[3] = {moved.x, moved.y, moved.z};
        double foreseen[3];
        for (int a = 0; a < 3; ++a) foreseen[a] = now[a] + kForeseenSteps * c.dt * p.velocity[a];
        tile.displacement.add(now, foreseen);
        // A sum is finite only if its terms are: not-a-number and infinity show here before they spread.
        const double probe = foreseen[0] + foreseen[1] + foreseen[2] + p.angular_velocity[0] + p.angular_velocity[1] + p.angular_velocity[2];
        tile.finite = tile.finite && std::isfinite(probe);
    }
}

} // namespace talus::core
