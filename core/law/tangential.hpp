// core/law/tangential.hpp: the force across the line of centres, with memory.
// Source   Mindlin (1949) no-slip stiffness k_t = 8 G* a; Coulomb cap; physics.md section 3.
// History  row (x, y, z, s): the spring force Fs [N] (or the displacement xi [m]) in the world frame, and |s| = the contact
//          radius of the last step, s < 0 when the contact slid in it. Zero on first touch, dropped on separation. Each step
//          the vector is carried into the new tangent plane keeping its length.
// Sign     returns the force on i
// Energy   force_rescaled and the linear law never gain; displacement with Hertz gains up to 0.33 % at e = 1, mu 0.6, because
//          k_t grows while xi is stored (that is what LAMMPS `mindlin` and LIGGGHTS do)
// Limits   mu = 0 or Fn = 0: no force and no history
// Needs    slip velocity, normal result, history row, time step
#pragma once

#include "core/law/normal.hpp"

namespace talus::core {

template <class V>
struct TangentialRow {
    Vec3<V> vector;
    V last; // |last| contact radius of the step before, sign: slid
};

template <class V>
struct TangentialForce {
    Vec3<V> force;  // N on i
    Vec3<V> spring; // N, its elastic part
    Mask<V> sliding;
};

/// The Coulomb cap on spring + damping; what is left in the spring is returned with it.
template <class V>
inline TangentialForce<V> cap_at_friction(const Vec3<V>& spring, const Vec3<V>& slip, V damping, V cap) {
    const V zero = splat<V>(0.0), one = splat<V>(1.0);
    damping = select(cap > zero, damping, zero); // without friction nothing stays in the spring
    const Vec3<V> trial = fnma(slip, damping, spring);
    const V share = cap / square_root(larger(dot(trial, trial), splat<V>(kTiny)));
    TangentialForce<V> r;
    r.sliding = share < one;
    r.force = trial * smaller(share, one);
    r.spring = fma(slip, damping, r.force);
    return r;
}

// A law with memory works in two stages. carry(): the spring of the last step in the present tangent plane, moved on by this
// step's slip. hold(): the force under the cap, and what stays in the row.

/// Force history; kRescale: Fs shrinks with the contact radius, so that unloading gives back no more than was stored.
template <bool kRescale>
struct ForceHistory {
    static constexpr bool kHasHistory = true;

    template <class V>
    static Vec3<V> carry(const ContactGeometry<V>& g, const NormalForce<V>& n, V dt, const TangentialRow<V>& row) {
        Vec3<V> spring;
        if constexpr (kRescale) {
            const V last = magnitude(row.last), least = smaller(n.contact_radius, last);
            spring = turn_into_plane(row.vector, g.normal, least * least, last * last);
        } else {
            spring = turn_into_plane(row.vector, g.normal, splat<V>(1.0), splat<V>(1.0));
        }
        return fnma(g.slip_velocity, n.stiffness_t * dt, spring);
    }
    template <class V>
    static TangentialForce<V> hold(const ContactGeometry<V>& g, const NormalForce<V>& n, V friction, const Vec3<V>& spring, TangentialRow<V>& row) {
        const auto r = cap_at_friction(spring, g.slip_velocity, n.damping_t, friction * magnitude(n.total));
        row.vector = r.spring;
        row.last = select(r.sliding, -n.contact_radius, n.contact_radius);
        return r;
    }
    /// The spring's force and stiffness in the last step, for energies.
    static Vec3d spring_force(const TangentialRow<double>& row, double /*stiffness*/) { return row.vector; }
};

/// What is carried is the displacement xi [m].
struct DisplacementHistory {
    static constexpr bool kHasHistory = true;

    template <class V>
    static Vec3<V> carry(const ContactGeometry<V>& g, const NormalForce<V>& /*n*/, V dt, const TangentialRow<V>& row) {
        return fma(g.slip_velocity, dt, turn_into_plane(row.vector, g.normal, splat<V>(1.0), splat<V>(1.0)));
    }
    template <class V>
    static TangentialForce<V> hold(const ContactGeometry<V>& g, const NormalForce<V>& n, V friction, const Vec3<V>& xi, TangentialRow<V>& row) {
        const V k = n.stiffness_t;
        const V cap = friction * magnitude(n.total);
        const auto r = cap_at_friction(xi * -k, g.slip_velocity, n.damping_t, cap);
        row.vector = r.spring * (splat<V>(-1.0) / larger(k, splat<V>(kTiny)));
        row.last = select(r.sliding, -n.contact_radius, n.contact_radius);
        return r;
    }
    static Vec3d spring_force(const TangentialRow<double>& row, double stiffness) { return row.vector * -stiffness; }
};

struct Frictionless {
    static constexpr bool kHasHistory = false;
};

} // namespace talus::core
