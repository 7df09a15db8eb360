// core/law/contact.hpp: one contact law out of three policies. The kernel, the energies and the contact output all call it.
#pragma once

#include <type_traits>

#include "core/law/rolling.hpp"
#include "core/law/tangential.hpp"
#include "core/material.hpp"

namespace talus::core {

/// Constants of a step that are the same for every contact, in lanes.
template <class V>
struct StepConstants {
    V dt;             // s
    V damping_floor;  // N: 0 for clipped, -infinity for attractive damping
    V rolling_rate;   // rad/s
};

template <class V>
struct ContactHistory {
    TangentialRow<V> tangential;
    Vec3<V> rolling;
};

template <class V>
struct ContactForce {
    Vec3<V> force;       // N on i; j gets the opposite
    Vec3<V> tangential;  // N, its part across the line of centres
    Vec3<V> moment_i;    // N m, rolling resistance; the friction's torques are -R n x tangential on both
    Vec3<V> moment_j;
    Mask<V> sliding;
};

template <class Normal, class Tangential, class Rolling>
struct ContactLaw {
    static constexpr int kHistoryDoubles = Rolling::kHasHistory ? 8 : (Tangential::kHasHistory ? 4 : 0);

    /// The force of a contact, and its history one step on. `heat`, where not NULL, gets the energy dissipated.
    template <class V>
    static ContactForce<V> evaluate(const ContactGeometry<V>& g, const ContactParameters<V>& p, const StepConstants<V>& c,
                                    ContactHistory<V>& history, Dissipation<V>* heat) {
        const V zero = splat<V>(0.0);
        const Vec3<V> none{zero, zero, zero};
        const NormalForce<V> n = Normal::evaluate(g, p, c.damping_floor);
        ContactForce<V> out{g.normal * n.total, none, none, none, zero > zero};
        if (heat) *heat = {zero, (n.elastic - n.total) * g.parting_speed * c.dt, zero};

        if constexpr (Tangential::kHasHistory) {
            const TangentialRow<V> before = history.tangential;
            const auto t = Tangential::evaluate(g, n, p.friction, c.dt, history.tangential);
            out.tangential = t.force;
            out.force = out.force + t.force;
            out.sliding = t.sliding;
            if (heat) account_tangential(g, n, p, c, before, t, *heat);
        }
        if constexpr (Rolling::kHasHistory) {
            const Vec3<V> before = history.rolling;
            const auto m = Rolling::evaluate(g, n, p, c.dt, history.rolling);
            out.moment_i = m.on_i;
            out.moment_j = m.on_j;
            if (heat) {
                const V stiffness = rolling_stiffness(g, n, p);
                const V stored = (dot(history.rolling, history.rolling) - dot(before, before)) * splat<V>(0.5) / larger(stiffness, splat<V>(kTiny));
                heat->rolling = -dot(m.on_i, g.rolling_rate) * c.dt - select(stiffness > zero, stored, zero);
            }
        } else if constexpr (std::is_same_v<Rolling, ConstantRolling>) {
            const auto m = Rolling::evaluate(g, n, p, c.rolling_rate, c.dt);
            out.moment_i = m.on_i;
            out.moment_j = m.on_j;
            // With own radii the two moments differ; the relative rotation sees their mean.
            if (heat) heat->rolling = -(dot(m.on_i, g.rolling_rate) - dot(m.on_j, g.rolling_rate)) * splat<V>(0.5) * c.dt;
        }
        return out;
    }

    /// Energy stored in a contact [J]: normal, tangential and rolling springs.
    struct Stored {
        double normal, tangential, rolling;
    };
    static Stored stored_energy(const ContactGeometry<double>& g, const ContactParameters<double>& p, const ContactHistory<double>& h) {
        const NormalForce<double> n = Normal::evaluate(g, p, 0.0);
        Stored s{Normal::kEnergyShare * n.elastic * g.overlap, 0.0, 0.0};
        if constexpr (Tangential::kHasHistory) {
            const Vec3d spring = Tangential::spring_force(h.tangential, n.stiffness_t);
            if (n.stiffness_t > 0.0) s.tangential = 0.5 * dot(spring, spring) / n.stiffness_t;
        }
        if constexpr (Rolling::kHasHistory) {
            const double k = rolling_stiffness(g, n, p);
            if (k > 0.0) s.rolling = 0.5 * dot(h.rolling, h.rolling) / k;
        }
        return s;
    }

    /// Energy left in the tangential spring of a contact that has just ended, with the stiffness of its last step [J].
    /// The rolling spring is empty by then: its cap vanishes with the normal force.
    static double released_energy(const ContactParameters<double>& p, const double* row) {
        if constexpr (Tangential::kHasHistory) {
            const double k = std::is_same_v<Normal, HertzNormal> ? p.stiffness_t * magnitude(row[3]) : p.stiffness_t;
            if (k > 0.0) {
                const Vec3d spring = Tangential::spring_force({{row[0], row[1], row[2]}, row[3]}, k);
                return 0.5 * dot(spring, spring) / k;
            }
        }
        return 0.0;
    }

private:
    template <class V>
    static V rolling_stiffness(const ContactGeometry<V>& g, const NormalForce<V>& n, const ContactParameters<V>& p) {
        const V lever = p.rolling_friction * g.radius_eff;
        return splat<V>(kRollingStiffness) * n.secant * (lever * lever);
    }

    /// Heat = work against the slip - growth of the stored energy; the dashpot's share is damping, the rest friction.
    template <class V>
    static void account_tangential(const ContactGeometry<V>& g, const NormalForce<V>& n, const ContactParameters<V>& p, const StepConstants<V>& c,
                                   const TangentialRow<V>& before, const TangentialForce<V>& t, Dissipation<V>& heat) {
        const V zero = splat<V>(0.0), tiny = splat<V>(kTiny), half = splat<V>(0.5);
        // The stiffness that the spring had a step ago: k_t is proportional to the contact radius (Hertz) or constant.
        const V k_before = std::is_same_v<Normal, HertzNormal> ? p.stiffness_t * magnitude(before.last) : p.stiffness_t;
        V stored_before = dot(before.vector, before.vector) * half;
        if constexpr (std::is_same_v<Tangential, DisplacementHistory>)
            stored_before = stored_before * k_before;
        else
            stored_before = select(k_before > zero, stored_before / larger(k_before, tiny), zero);
        const V stored = select(n.stiffness_t > zero, dot(t.spring, t.spring) * half / larger(n.stiffness_t, tiny), zero);
        const V work = -dot(t.force, g.slip_velocity) * c.dt;
        const V dashpot = select(t.sliding, zero, n.damping_t * dot(g.slip_velocity, g.slip_velocity) * c.dt);
        heat.damping = heat.damping + dashpot;
        heat.friction = work - (stored - stored_before) - dashpot;
    }
};

} // namespace talus::core
