#include "core/integrate.hpp"

#include <limits>

namespace talus::core {

void collect_border(const std::vector<Tile>& tiles, Tile& tile) {
    for (const IncomingSums& in : tile.incoming) {
        const Tile& from = tiles[in.from_tile];
        for (TileLocal id = in.first; id < in.first + in.count; ++id) tile.sums[from.index_of[id] - tile.first] += from.sums[id];
    }
}

namespace {

V4 three(const double (&v)[3], double fourth) { return V4{v[0], v[1], v[2], fourth}; }
V4 as_double(const std::int64_t (&n)[3]) {
    return V4{static_cast<double>(n[0]), static_cast<double>(n[1]), static_cast<double>(n[2]), 0.0};
}
void put(V4 v, double (&out)[3]) {
    for (int a = 0; a < 3; ++a) out[a] = v[a];
}

/// Lanes x, y, z of a row; the fourth holds radius, mass, meta or label, whose bits must stay as they are.
constexpr unsigned kSpatial = 0b0111;

} // namespace

void integrate_tile(const IntegrateContext& c, Particle* particles, Reference* references, Tile& tile) {
    if (!c.finish && !c.begin) return;
    const double half = 0.5 * c.dt;
    // A factor of zero in the fourth lane leaves radius and mass unchanged to the bit.
    const V4 gravity_kick = three(c.gravity, 0.0) * splat<V4>(half);
    const V4 drift{c.dt, c.dt, c.dt, 0.0}, foresight = drift * splat<V4>(kForeseenSteps);
    const double inf = std::numeric_limits<double>::infinity();
    V4 wrap_lo = splat<V4>(-inf), wrap_hi = splat<V4>(inf);
    for (int a = 0; a < 3; ++a) {
        if (!c.domain.periodic[a]) continue;
        wrap_lo[a] = c.domain.lo[a];
        wrap_hi[a] = c.domain.hi[a];
    }
    V4 lo = splat<V4>(inf), hi = splat<V4>(-inf), foreseen_lo = lo, foreseen_hi = hi;
    unsigned sound = kSpatial;

    for (std::uint32_t k = 0; k < tile.count; ++k) {
        Particle& p = particles[tile.first + k];
        const ForceSum& sum = tile.sums[k];
        const GroupMotion& motion = c.groups[group_of(p)];
        V4 velocity = load_row(p.velocity);
        V4 turning = three(p.angular_velocity, 0.0);
        if (motion.mode == GroupMotion::Mode::free) [[likely]] {
            const V4 force = as_double(sum.force) * splat<V4>(c.units.force.unit);
            const V4 torque = as_double(sum.torque) * splat<V4>(c.units.torque.unit);
            const V4 kick = splat<V4>(half / p.mass);
            const V4 spin = splat<V4>(half / (kSphereInertia * p.mass * (p.radius * p.radius)));
            for (int pass = (c.finish ? 1 : 0) + (c.begin ? 1 : 0); pass > 0; --pass) {
                velocity = fma(force, kick, velocity) + gravity_kick;
                turning = fma(torque, spin, turning);
            }
        } else {
            const bool driven = motion.mode == GroupMotion::Mode::driven;
            velocity = driven ? three(motion.velocity, p.mass) : V4{0.0, 0.0, 0.0, p.mass};
            turning = driven ? three(motion.angular_velocity, 0.0) : splat<V4>(0.0);
        }
        store_row(p.velocity, velocity);
        put(turning, p.angular_velocity);
        if (!c.begin) continue;

        const V4 position = fma(velocity, drift, load_row(p.position));
        store_row(p.position, position);
        if ((bits_of((position >= wrap_hi) | (position < wrap_lo)) & kSpatial) != 0) [[unlikely]] {
            const Vec3d before = make_vec3(p.position);
            wrap(c.domain, p.position, references[tile.first + k]);
            // Where the grain was listed moves along: a bed that slides as a whole may pass half a period before the next rebuild.
            const Vec3d shift = make_vec3(p.position) - before;
            p.listed_position[0] += shift.x;
            p.listed_position[1] += shift.y;
            p.listed_position[2] += shift.z;
        }

        const V4 moved = load_row(p.position) - load_row(p.listed_position);
        const V4 foreseen = fma(velocity, foresight, moved);
        lo = smaller(moved, lo);
        hi = larger(moved, hi);
        foreseen_lo = smaller(foreseen, foreseen_lo);
        foreseen_hi = larger(foreseen, foreseen_hi);
        // Infinite or not a number in any of them fails the comparison.
        sound &= bits_of((magnitude(foreseen) < splat<V4>(inf)) & (magnitude(turning) < splat<V4>(inf)));
    }
    if (!c.begin) return;
    DisplacementBox& box = tile.displacement;
    put(lo, box.lo);
    put(hi, box.hi);
    put(foreseen_lo, box.foreseen_lo);
    put(foreseen_hi, box.foreseen_hi);
    tile.finite = sound == kSpatial;
}

} // namespace talus::core
