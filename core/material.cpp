#include "core/material.hpp"

#include <cmath>

#include "core/constants.hpp"

namespace talus::core {

double clipped_restitution(double zeta) {
    if (zeta < 1.0) {
        const double s = std::sqrt(1.0 - zeta * zeta);
        return std::exp(-(zeta / s) * (kPi - std::atan2(2.0 * zeta * s, 1.0 - 2.0 * zeta * zeta)));
    }
    if (zeta == 1.0) return std::exp(-2.0);
    const double q = std::sqrt(zeta * zeta - 1.0);
    return std::exp(-(zeta / q) * std::log((zeta + q) / (zeta - q)));
}

double clipped_damping_ratio(double e) {
    if (e >= 1.0) return 0.0;
    double lo = 0.0, hi = 1.0;
    while (clipped_restitution(hi) > e) hi *= 2.0;
    // Bisection to the last bit: the function is monotone, and this runs once per material pair.
    for (int k = 0; k < 200; ++k) {
        const double mid = 0.5 * (lo + hi);
        if (mid == lo || mid == hi) break;
        (clipped_restitution(mid) > e ? lo : hi) = mid;
    }
    return 0.5 * (lo + hi);
}

double viscous_damping_ratio(double e) {
    const double l = std::log(e);
    return -l / std::sqrt(kPi * kPi + l * l);
}

namespace {

double shear_modulus(const Material& m) { return m.young / (2.0 * (1.0 + m.poisson)); }

double effective_shear(const Material& a, const Material& b) {
    const auto compliance = [](const Material& m) { return m.rigid ? 0.0 : (2.0 - m.poisson) / shear_modulus(m); };
    return 1.0 / (compliance(a) + compliance(b));
}

} // namespace

double effective_young(const Material& a, const Material& b) {
    const auto compliance = [](const Material& m) { return m.rigid ? 0.0 : (1.0 - m.poisson * m.poisson) / m.young; };
    return 1.0 / (compliance(a) + compliance(b));
}

PairParameters derive_parameters(const Material& a, const Material& b, const ContactMaterial& contact, const Laws& laws) {
    const double beta = viscous_damping_ratio(contact.restitution);
    const double zeta = laws.damping == Damping::clipped ? clipped_damping_ratio(contact.restitution) : beta;
    PairParameters p;
    if (laws.normal == NormalLaw::hertz) {
        const double young = effective_young(a, b), shear = effective_shear(a, b);
        p.stiffness_n = 2.0 * young;
        p.stiffness_t = 8.0 * shear;
        // gamma_n = sqrt(5) zeta sqrt(m* K) delta^(1/4), K = 4/3 E* sqrt(R*), and sqrt(R* delta) = a.
        p.damping_n = std::sqrt(5.0) * zeta * std::sqrt(4.0 / 3.0 * young);
        p.damping_t = 2.0 * std::sqrt(5.0 / 6.0) * beta * std::sqrt(p.stiffness_t);
    } else {
        p.stiffness_n = laws.stiffness_n;
        p.stiffness_t = laws.stiffness_t > 0.0 ? laws.stiffness_t : 2.0 / 7.0 * laws.stiffness_n;
        p.damping_n = 2.0 * zeta * std::sqrt(p.stiffness_n);
        p.damping_t = 2.0 * beta * std::sqrt(p.stiffness_t);
    }
    if (!laws.tangential_damping) p.damping_t = 0.0;
    p.friction = contact.friction;
    p.rolling_friction = contact.rolling_friction;
    p.rolling_damping = laws.rolling_damping;
    return p;
}

double rayleigh_step(const Material& m, double radius) {
    return kPi * radius * std::sqrt(m.density / shear_modulus(m)) / (kRayleighSlope * m.poisson + kRayleighOffset);
}

} // namespace talus::core
