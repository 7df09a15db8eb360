// core/law/geometry.hpp: what a contact law sees, the same for grain on grain and grain on wall.
#pragma once

#include "core/constants.hpp"
#include "core/vec3.hpp"

namespace talus::core {

/// i is the grain with the smaller label; j the other one or the wall.
template <class V>
struct ContactGeometry {
    Vec3<V> normal;         // 1, from j to i
    V overlap;              // m, >= 0
    V radius_eff;           // m, R* = Ri Rj / (Ri + Rj); R at a wall
    V mass_eff;             // kg, m* = mi mj / (mi + mj); m at a wall
    V parting_speed;        // m/s, vr.n
    Vec3<V> slip_velocity;  // m/s, vt = vr - (vr.n) n - (Ri wi + Rj wj) x n
    Vec3<V> rolling_rate;   // rad/s, (wi - wj) without its part along n
    V rolling_radius_i;     // m, R* or each grain's own
    V rolling_radius_j;     // m
    V rolling_inertia;      // kg m^2, Ir of Ai et al. (2011); set only for the rolling spring
};

/// PairParameters in lanes.
template <class V>
struct ContactParameters {
    V stiffness_n, stiffness_t, damping_n, damping_t, friction, rolling_friction, rolling_damping;
};

/// Turn a tangential vector into the plane across n; its length becomes sqrt(scale / over) of what it was. Zero stays zero.
/// The scale comes as a fraction so that one division serves the turn and the rescaling.
template <class V>
inline Vec3<V> turn_into_plane(const Vec3<V>& h, const Vec3<V>& n, V scale, V over) {
    const Vec3<V> t = fnma(n, dot(h, n), h);
    const V before = dot(h, h) * scale, after = dot(t, t) * over;
    const V tiny = splat<V>(kTiny);
    return t * square_root(select(after > tiny, before / larger(after, tiny), splat<V>(0.0)));
}

/// Energy turned into heat in one step, J; negative values are errors of the time step.
template <class V>
struct Dissipation {
    V friction, damping, rolling;
};

} // namespace talus::core
