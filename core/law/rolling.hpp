// core/law/rolling.hpp: the torque against rolling.
// Source   Ai, Chen, Rotter and Ooi (2011): type A (constant directional torque) and type C (elastic-plastic spring-dashpot);
//          physics.md section 4.
// Symbols  w_r [rad/s] relative angular velocity without its part along n; R_r [m] R* or, type A on request, own radius
// History  type C: row (x, y, z, 0): the spring's moment on i [N m]
// Sign     returns the moment on i; j gets the opposite (type A with own radius: its own)
// Limits   type A falls to zero with w_r below `rate`, or below the rate that one step of the torque would stop if that is larger:
//          on a slope it creeps, bounded by these; it cannot hold exactly
// Needs    rolling rate, normal force (its repulsive part), type C: secant stiffness, rolling inertia, time step
#pragma once

#include "core/constants.hpp"
#include "core/law/normal.hpp"

namespace talus::core {

template <class V>
struct Moments {
    Vec3<V> on_i, on_j;
};

struct NoRolling {
    static constexpr bool kHasHistory = false;
};

struct ConstantRolling {
    static constexpr bool kHasHistory = false;

    /// The torque of one step must not turn the rotation round: below the rate that it would stop in a step, it falls with the
    /// rate. J = 0.4 m* R*^2 is the inertia of a grain against a wall, and a quarter of that of two equal grains against each
    /// other, so that the several contacts of a grain together do not overshoot either.
    template <class V>
    static Moments<V> evaluate(const ContactGeometry<V>& g, const NormalForce<V>& n, const ContactParameters<V>& p, V rate, V dt) {
        const V speed = square_root(dot(g.rolling_rate, g.rolling_rate));
        const V force = p.rolling_friction * larger(n.total, splat<V>(0.0));
        const V inertia = splat<V>(kSphereInertia) * g.mass_eff * (g.radius_eff * g.radius_eff);
        const V m = force * inertia / larger(larger(speed, rate) * inertia, force * g.radius_eff * dt);
        return {g.rolling_rate * (-m * g.rolling_radius_i), g.rolling_rate * (m * g.rolling_radius_j)};
    }
};

/// In two stages, as the tangential laws: carry() the spring's moment, hold() it under the cap.
struct SpringRolling {
    static constexpr bool kHasHistory = true;

    template <class V>
    static V stiffness(const ContactGeometry<V>& g, const NormalForce<V>& n, const ContactParameters<V>& p) {
        const V lever = p.rolling_friction * g.radius_eff;
        return splat<V>(kRollingStiffness) * n.secant * (lever * lever);
    }
    template <class V>
    static Vec3<V> carry(const ContactGeometry<V>& g, const NormalForce<V>& n, const ContactParameters<V>& p, V dt, const Vec3<V>& moment) {
        return fnma(g.rolling_rate, stiffness(g, n, p) * dt, turn_into_plane(moment, g.normal, splat<V>(1.0), splat<V>(1.0)));
    }
    /// @param moment  what stays in the row
    template <class V>
    static Moments<V> hold(const ContactGeometry<V>& g, const NormalForce<V>& n, const ContactParameters<V>& p, const Vec3<V>& spring, Vec3<V>& moment) {
        const V cap = p.rolling_friction * g.radius_eff * larger(n.total, splat<V>(0.0));
        const V zero = splat<V>(0.0);
        const V square = dot(spring, spring);
        const auto mobilised = square > cap * cap;
        const V factor = select(mobilised, cap / square_root(larger(square, splat<V>(kTiny))), splat<V>(1.0));
        const V damping = select(mobilised | (cap <= zero), zero, splat<V>(2.0) * p.rolling_damping * square_root(g.rolling_inertia * stiffness(g, n, p)));
        moment = spring * factor;
        const Vec3<V> on_i = fnma(g.rolling_rate, damping, moment);
        return {on_i, -on_i};
    }
};

} // namespace talus::core
