// core/contact_lanes.hpp: from records of grains to the lanes of a contact law. The one place where a contact's geometry is
// computed; kernels of every width and the observers use it.
#pragma once

#include "core/domain.hpp"
#include "core/law/geometry.hpp"
#include "core/material.hpp"

namespace talus::core {

/// Records of W grains, transposed.
template <class V>
struct GrainLanes {
    Vec3<V> position;
    V radius;
    Vec3<V> velocity;
    V mass;
    Vec3<V> angular_velocity;
};

/// @param records  kLanes<V> pointers, 32-byte aligned
template <class V>
inline GrainLanes<V> load_grains(const Particle* const* records) {
    const double* rows[kLanes<V>];
    V q[4];
    GrainLanes<V> g;
    for (int l = 0; l < kLanes<V>; ++l) rows[l] = records[l]->position;
    load_columns(rows, q);
    g.position = {q[0], q[1], q[2]};
    g.radius = q[3];
    for (int l = 0; l < kLanes<V>; ++l) rows[l] = records[l]->velocity;
    load_columns(rows, q);
    g.velocity = {q[0], q[1], q[2]};
    g.mass = q[3];
    for (int l = 0; l < kLanes<V>; ++l) rows[l] = records[l]->angular_velocity;
    load_columns(rows, q);
    g.angular_velocity = {q[0], q[1], q[2]};
    return g;
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
template <class V>
inline Mask<V> touches(const Periods& periods, const Vec3<V>& xi, V ri, const Vec3<V>& xj, V rj) {
    const Vec3<V> d = minimum_image(periods, xi - xj);
    const V reach = ri + rj;
    return dot(d, d) < reach * reach;
}

/// Grain i on grain j; `own_radius` tells the rolling convention, kInertia whether the rolling spring needs Ir.
template <bool kInertia, class V>
inline ContactGeometry<V> pair_geometry(const Periods& periods, const GrainLanes<V>& i, const GrainLanes<V>& j, bool own_radius) {
    ContactGeometry<V> g;
    const Vec3<V> d = minimum_image(periods, i.position - j.position);
    const V distance = square_root(dot(d, d));
    const V one = splat<V>(1.0);
    g.normal = d * (one / larger(distance, splat<V>(kTiny)));
    const V reach = i.radius + j.radius, mass_sum = i.mass + j.mass;
    g.overlap = larger(reach - distance, splat<V>(0.0));
    // One division serves both effective quantities.
    const V inverse = one / (reach * mass_sum);
    g.radius_eff = i.radius * j.radius * (mass_sum * inverse);
    g.mass_eff = i.mass * j.mass * (reach * inverse);
    const Vec3<V> vr = i.velocity - j.velocity;
    g.parting_speed = dot(vr, g.normal);
    const Vec3<V> spin = fma(i.angular_velocity, i.radius, j.angular_velocity * j.radius);
    g.slip_velocity = fnma(g.normal, g.parting_speed, vr) - cross(spin, g.normal);
    const Vec3<V> wr = i.angular_velocity - j.angular_velocity;
    g.rolling_rate = fnma(g.normal, dot(wr, g.normal), wr);
    g.rolling_radius_i = own_radius ? i.radius : g.radius_eff;
    g.rolling_radius_j = own_radius ? j.radius : g.radius_eff;
    if constexpr (kInertia) {
        const V a = i.mass * (i.radius * i.radius), b = j.mass * (j.radius * j.radius);
        g.rolling_inertia = splat<V>(kRollingInertia) * (a * b / (a + b));
    }
    return g;
}

/// Height of a centre above a plane [m].
template <class V>
inline V height_above(const Vec3d& point, const Vec3d& normal, const Vec3<V>& x) {
    const Vec3<V> d{x.x - splat<V>(point.x), x.y - splat<V>(point.y), x.z - splat<V>(point.z)};
    return dot(d, Vec3<V>{splat<V>(normal.x), splat<V>(normal.y), splat<V>(normal.z)});
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
