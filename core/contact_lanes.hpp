// core/contact_lanes.hpp: from records of grains to the lanes of a contact law. The one place where a contact's geometry is
// computed; kernels of every width and the observers use it.
#pragma once

#include "core/domain.hpp"
#include "core/law/geometry.hpp"
#include "core/material.hpp"

namespace talus::core {

/// W grains, transposed.
template <class V>
struct GrainLanes {
    Vec3<V> position;
    V radius;
    Vec3<V> velocity;
    V mass;
    Vec3<V> angular_velocity;
};

/// Lanes of one record.
inline GrainLanes<double> load_grain(const Particle& p) {
    return {make_vec3(p.position), p.radius, make_vec3(p.velocity), p.mass, make_vec3(p.angular_velocity)};
}

template <class V>
inline ContactParameters<V> load_parameters(const PairParameters* const* tables) {
    const double* rows[kLanes<V>];
    V q[4], r[4];
    for (int l = 0; l < kLanes<V>; ++l) rows[l] = &tables[l]->stiffness_n;
    load_columns(rows, q);
    for (int l = 0; l < kLanes<V>; ++l) rows[l] = &tables[l]->friction;
    load_columns(rows, r);
    return {q[0], q[1], q[2], q[3], r[0], r[1], r[2]};
}

template <class V>
inline ContactParameters<V> splat_parameters(const PairParameters& p) {
    return {splat<V>(p.stiffness_n), splat<V>(p.stiffness_t), splat<V>(p.damping_n), splat<V>(p.damping_t),
            splat<V>(p.friction), splat<V>(p.rolling_friction), splat<V>(p.rolling_damping)};
}

/// Squared distance of centres and of touch; a pair touches when the first is below the second. Even under exchange of the two.
/// @param periods  Periods or NoPeriods
template <class V, class Images>
inline Mask<V> touches(const Images& periods, const Vec3<V>& xi, V ri, const Vec3<V>& xj, V rj) {
    const Vec3<V> d = minimum_image(periods, xi - xj);
    const V reach = ri + rj;
    return dot(d, d) < reach * reach;
}

// The geometry of grain i on grain j in four parts, each after those before it.

/// @return whether they touch
template <class V, class Images>
inline Mask<V> set_overlap(const Images& periods, const Vec3<V>& xi, V ri, const Vec3<V>& xj, V rj, ContactGeometry<V>& g) {
    const Vec3<V> d = minimum_image(periods, xi - xj);
    const V distance = square_root(dot(d, d));
    g.normal = d * (splat<V>(1.0) / larger(distance, splat<V>(kTiny)));
    g.overlap = larger(ri + rj - distance, splat<V>(0.0));
    return touches<V>(periods, xi, ri, xj, rj);
}
template <class V>
inline void set_approach(const Vec3<V>& vi, const Vec3<V>& vj, ContactGeometry<V>& g) {
    const Vec3<V> vr = vi - vj;
    g.parting_speed = dot(vr, g.normal);
    g.slip_velocity = fnma(g.normal, g.parting_speed, vr); // of the centres; set_spin completes it
}
template <class V>
inline void set_spin(const Vec3<V>& wi, V ri, const Vec3<V>& wj, V rj, ContactGeometry<V>& g) {
    g.slip_velocity = g.slip_velocity - cross(fma(wi, ri, wj * rj), g.normal);
    const Vec3<V> wr = wi - wj;
    g.rolling_rate = fnma(g.normal, dot(wr, g.normal), wr);
}
/// @param own_radius  the rolling convention; kInertia: whether the rolling spring needs Ir
template <bool kInertia, class V>
inline void set_scales(V ri, V mi, V rj, V mj, bool own_radius, ContactGeometry<V>& g) {
    const V reach = ri + rj, mass_sum = mi + mj;
    // One division serves both effective quantities.
    const V inverse = splat<V>(1.0) / (reach * mass_sum);
    g.radius_eff = ri * rj * (mass_sum * inverse);
    g.mass_eff = mi * mj * (reach * inverse);
    g.rolling_radius_i = own_radius ? ri : g.radius_eff;
    g.rolling_radius_j = own_radius ? rj : g.radius_eff;
    if constexpr (kInertia) {
        const V a = mi * (ri * ri), b = mj * (rj * rj);
        g.rolling_inertia = splat<V>(kRollingInertia) * (a * b / (a + b));
    }
}
template <bool kInertia, class V>
inline ContactGeometry<V> pair_geometry(const Periods& periods, const GrainLanes<V>& i, const GrainLanes<V>& j, bool own_radius) {
    ContactGeometry<V> g;
    set_overlap(periods, i.position, i.radius, j.position, j.radius, g);
    set_approach(i.velocity, j.velocity, g);
    set_spin(i.angular_velocity, i.radius, j.angular_velocity, j.radius, g);
    set_scales<kInertia>(i.radius, i.mass, j.radius, j.mass, own_radius, g);
    return g;
}

/// Height of a centre above a plane [m].
template <class V>
inline V height_above(const Vec3d& point, const Vec3d& normal, const Vec3<V>& x) {
    const Vec3<V> d{x.x - splat<V>(point.x), x.y - splat<V>(point.y), x.z - splat<V>(point.z)};
    return dot(d, Vec3<V>{splat<V>(normal.x), splat<V>(normal.y), splat<V>(normal.z)});
}

template <class V>
inline Mask<V> touches_plane(const Vec3d& point, const Vec3d& normal, const Vec3<V>& x, V radius) {
    return height_above(point, normal, x) < radius;
}

/// Grain i on a plane that moves at `velocity`: R* = R, m* = m, and j does not turn.
template <bool kInertia, class V>
inline ContactGeometry<V> wall_geometry(const Vec3d& point, const Vec3d& normal, const Vec3d& velocity, const GrainLanes<V>& i) {
    ContactGeometry<V> g;
    g.normal = {splat<V>(normal.x), splat<V>(normal.y), splat<V>(normal.z)};
    g.overlap = larger(i.radius - height_above(point, normal, i.position), splat<V>(0.0));
    g.radius_eff = i.radius;
    g.mass_eff = i.mass;
    const Vec3<V> vr = i.velocity - Vec3<V>{splat<V>(velocity.x), splat<V>(velocity.y), splat<V>(velocity.z)};
    g.parting_speed = dot(vr, g.normal);
    g.slip_velocity = fnma(g.normal, g.parting_speed, vr) - cross(i.angular_velocity * i.radius, g.normal);
    g.rolling_rate = fnma(g.normal, dot(i.angular_velocity, g.normal), i.angular_velocity);
    g.rolling_radius_i = i.radius;
    g.rolling_radius_j = i.radius;
    if constexpr (kInertia) g.rolling_inertia = splat<V>(kRollingInertia) * (i.mass * (i.radius * i.radius));
    return g;
}

} // namespace talus::core
