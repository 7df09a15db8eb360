// core/law/normal.hpp: the force along the line of centres.
// Source   physics.md section 2. Hertz (1882): Fn = 4/3 E* sqrt(R*) d^(3/2); damping Tsuji et al. (1992) with alpha = sqrt(5)
//          zeta. Linear: Fn = k d - 2 zeta sqrt(k m*) vn.
// Symbols  overlap d [m] > 0 in touch; a = sqrt(R* d) [m] contact radius; vn [m/s] > 0 when parting; n from j to i
// Sign     the force on i along n is positive in repulsion
// Damping  clipped: the sum is never negative (floor 0); attractive: floor -infinity
// Energy   never grows over a contact (tested); at e = 1 conserved
// Needs    overlap, R*, m*, vn
#pragma once

#include "core/law/geometry.hpp"

namespace talus::core {

template <class V>
struct NormalForce {
    V total;          // N, with damping, not below the floor
    V elastic;        // N
    V contact_radius; // m; 1 for the linear law, whose stiffness does not depend on it
    V stiffness_t;    // N/m
    V damping_t;      // kg/s
    V secant;         // N/m: elastic force / overlap, for the rolling spring
};

struct HertzNormal {
    static constexpr double kEnergyShare = 0.4; // elastic energy = 2/5 F d

    template <class V>
    static NormalForce<V> evaluate(const ContactGeometry<V>& g, const ContactParameters<V>& p, V floor) {
        NormalForce<V> r;
        const V a = square_root(g.radius_eff * g.overlap);
        const V damping = square_root(a * g.mass_eff);
        r.contact_radius = a;
        r.secant = splat<V>(2.0 / 3.0) * p.stiffness_n * a;
        r.elastic = r.secant * g.overlap;
        r.total = larger(fnma(p.damping_n * damping, g.parting_speed, r.elastic), floor);
        r.stiffness_t = p.stiffness_t * a;
        r.damping_t = p.damping_t * damping;
        return r;
    }
};

struct LinearNormal {
    static constexpr double kEnergyShare = 0.5;

    template <class V>
    static NormalForce<V> evaluate(const ContactGeometry<V>& g, const ContactParameters<V>& p, V floor) {
        NormalForce<V> r;
        const V damping = square_root(g.mass_eff);
        r.contact_radius = splat<V>(1.0);
        r.secant = p.stiffness_n;
        r.elastic = p.stiffness_n * g.overlap;
        r.total = larger(fnma(p.damping_n * damping, g.parting_speed, r.elastic), floor);
        r.stiffness_t = p.stiffness_t;
        r.damping_t = p.damping_t * damping;
        return r;
    }
};

} // namespace talus::core
