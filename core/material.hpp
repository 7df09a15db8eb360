// core/material.hpp: what the user says of materials, and what a contact needs of it.
// Source   Hertz-Mindlin with Tsuji et al. (1992) damping; the exact restitution of the oscillator that is cut off when its
//          force would attract (derived for this project, physics.md section 2; compare Schwager and Poeschel 2007).
#pragma once

#include <vector>

#include "core/types.hpp"

namespace talus::core {

struct Material {
    double young = 0;   // Pa; infinite when rigid
    double poisson = 0; // 1
    double density = 0; // kg/m^3
    bool rigid = false;
};

struct ContactMaterial {
    double restitution = 1; // 1, 0.05..1
    double friction = 0;    // 1
    double rolling_friction = 0;
    bool is_set = false;
};

enum class NormalLaw : std::int32_t { hertz = 0, linear = 1 };
enum class Damping : std::int32_t { clipped = 0, attractive = 1 };
enum class TangentialLaw : std::int32_t { force_rescaled = 0, force = 1, displacement = 2, none = 3 };
enum class RollingLaw : std::int32_t { none = 0, constant = 1, spring = 2 };
enum class RollingRadius : std::int32_t { effective = 0, own = 1 };

struct Laws {
    NormalLaw normal = NormalLaw::hertz;
    Damping damping = Damping::clipped;
    TangentialLaw tangential = TangentialLaw::force_rescaled;
    RollingLaw rolling = RollingLaw::constant;
    RollingRadius rolling_radius = RollingRadius::effective;
    bool tangential_damping = true;
    double rolling_rate = 1e-3;   // rad/s
    double rolling_damping = 0.3; // 1
    double stiffness_n = 0;       // N/m, linear law
    double stiffness_t = 0;       // N/m, linear law
};

/// Doubles of history that a contact carries: none, the tangential spring's four, or those and the rolling spring's three.
inline int history_doubles(const Laws& l) {
    if (l.rolling == RollingLaw::spring) return 7;
    return l.tangential == TangentialLaw::none ? 0 : 4;
}

/// Derived constants of a pair of materials, in the order the kernel loads them (two rows of four).
struct alignas(64) PairParameters {
    double stiffness_n = 0; // Hertz: 2 E* [Pa], S_n = stiffness_n a;  linear: k [N/m]
    double stiffness_t = 0; // Hertz: 8 G* [Pa], k_t = stiffness_t a;  linear: k_t [N/m]
    double damping_n = 0;   // Hertz: gamma_n = damping_n sqrt(a m*);  linear: damping_n sqrt(m*)
    double damping_t = 0;   // the same for gamma_t
    double friction = 0;
    double rolling_friction = 0;
    double rolling_damping = 0;
    double pad = 0;
};
static_assert(sizeof(PairParameters) == 64);

/// Restitution of the damped oscillator that never attracts, as a function of its damping ratio zeta >= 0.
double clipped_restitution(double zeta);
/// The damping ratio whose clipped restitution is e, 0 < e <= 1.
double clipped_damping_ratio(double e);
/// The damping ratio of the full half period: -ln e / sqrt(pi^2 + ln^2 e).
double viscous_damping_ratio(double e);

/// Uses log and exp, which differ between processors: call on one rank and broadcast the result.
PairParameters derive_parameters(const Material& a, const Material& b, const ContactMaterial& contact, const Laws& laws);

/// E* [Pa] of two materials; either may be rigid, not both.
double effective_young(const Material& a, const Material& b);

/// Rayleigh step of a grain [s] (Li et al. 2005).
double rayleigh_step(const Material& m, double radius);

} // namespace talus::core
