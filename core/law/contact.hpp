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
};

/// What a law knows of a contact, from its geometry and history to its force.
template <class V>
struct ContactState {
    ContactGeometry<V> geometry;
    ContactHistory<V> history; // in and out
    ContactHistory<V> before;  // as it came; set by the first stage of a law with a ledger
    NormalForce<V> normal;
    TangentialForce<V> held;
    Vec3<V> carried, carried_moment;
    ContactForce<V> force;
    Dissipation<V> heat;
};

template <class Normal, class Tangential, class Rolling>
struct ContactLaw {
    static constexpr int kHistoryDoubles = Rolling::kHasHistory ? 7 : (Tangential::kHasHistory ? 4 : 0);
    static constexpr bool kNeedsInertia = Rolling::kHasHistory;

    /// The law as stages: apply(stage) is called for each in order, and stage(x, p) takes a ContactState and the parameters of
    /// its pair. A stage is short enough for a processor to work on several contacts at once when it runs over a batch of them;
    /// as one piece the law is a single long chain of square roots and divisions. Geometry and history must be set.
    template <class V, bool kLedger, class Apply>
    static void stages(const StepConstants<V>& c, Apply apply) {
        using State = ContactState<V>;
        using Parameters = ContactParameters<V>;
        const V zero = splat<V>(0.0);
        const Vec3<V> none{zero, zero, zero};
        apply([&](State& x, const Parameters& p) {
            if constexpr (kLedger) x.before = x.history;
            x.normal = Normal::evaluate(x.geometry, p, c.damping_floor);
            if constexpr (!Tangential::kHasHistory) {
                x.force.tangential = none;
                x.force.force = x.geometry.normal * x.normal.total;
            }
            if constexpr (std::is_same_v<Rolling, NoRolling>) x.force.moment_i = x.force.moment_j = none;
        });
        // What the springs carry over, and the rolling torque that has none: independent chains, which fill each other's waits.
        const auto set_moments = [](State& x, const Moments<V>& m) {
            x.force.moment_i = m.on_i;
            x.force.moment_j = m.on_j;
        };
        if constexpr (Tangential::kHasHistory || !std::is_same_v<Rolling, NoRolling>)
            apply([&](State& x, const Parameters& p) {
                if constexpr (Tangential::kHasHistory) x.carried = Tangential::carry(x.geometry, x.normal, c.dt, x.history.tangential);
                if constexpr (Rolling::kHasHistory) x.carried_moment = Rolling::carry(x.geometry, x.normal, p, c.dt, x.history.rolling);
                if constexpr (std::is_same_v<Rolling, ConstantRolling>) set_moments(x, Rolling::evaluate(x.geometry, x.normal, p, c.rolling_rate, c.dt));
            });
        if constexpr (Tangential::kHasHistory || Rolling::kHasHistory)
            apply([&](State& x, const Parameters& p) {
                if constexpr (Tangential::kHasHistory) {
                    const auto t = Tangential::hold(x.geometry, x.normal, p.friction, x.carried, x.history.tangential);
                    x.force.tangential = t.force;
                    x.force.force = x.geometry.normal * x.normal.total + t.force;
                    if constexpr (kLedger) x.held = t;
                }
                if constexpr (Rolling::kHasHistory) set_moments(x, Rolling::hold(x.geometry, x.normal, p, x.carried_moment, x.history.rolling));
            });
        if constexpr (kLedger) apply([&](State& x, const Parameters& p) { account(x, p, c); });
    }

    /// The force of a contact whose geometry and history are set, and its history one step on.
    template <class V>
    static void evaluate(ContactState<V>& x, const ContactParameters<V>& p, const StepConstants<V>& c) {
        stages<V, false>(c, [&](auto stage) { stage(x, p); });
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
            const double k = Rolling::stiffness(g, n, p);
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
    /// Energy dissipated in the step.
    template <class V>
    static void account(ContactState<V>& x, const ContactParameters<V>& p, const StepConstants<V>& c) {
        const V zero = splat<V>(0.0), half = splat<V>(0.5);
        const ContactGeometry<V>& g = x.geometry;
        const NormalForce<V>& n = x.normal;
        x.heat = {zero, (n.elastic - n.total) * g.parting_speed * c.dt, zero};
        if constexpr (Tangential::kHasHistory) account_tangential(g, n, p, c, x.before.tangential, x.held, x.heat);
        if constexpr (Rolling::kHasHistory) {
            const V stiffness = Rolling::stiffness(g, n, p);
            const V stored = (dot(x.history.rolling, x.history.rolling) - dot(x.before.rolling, x.before.rolling)) * half / larger(stiffness, splat<V>(kTiny));
            x.heat.rolling = -dot(x.force.moment_i, g.rolling_rate) * c.dt - select(stiffness > zero, stored, zero);
        } else if constexpr (std::is_same_v<Rolling, ConstantRolling>) {
            // With own radii the two moments differ; the relative rotation sees their mean.
            x.heat.rolling = -(dot(x.force.moment_i, g.rolling_rate) - dot(x.force.moment_j, g.rolling_rate)) * half * c.dt;
        }
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
