// theory.hpp: closed forms that physics tests compare with, written from physics.md and from nothing in core/.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

namespace talus::test {

inline constexpr double kPi = std::numbers::pi;

/// What a test needs of a material.
struct Solid {
    double young;
    double poisson;
    double density;
    double shear() const { return young / (2.0 * (1.0 + poisson)); }
    double mass(double radius) const { return density * 4.0 / 3.0 * kPi * radius * radius * radius; }
    /// Rayleigh's step of a grain.
    double rayleigh_step(double radius) const { return kPi * radius * std::sqrt(density / shear()) / (0.1631 * poisson + 0.8766); }
};

/// The sand of the paper, at its mean diameter.
inline constexpr Solid kSand{1.0e7, 0.2, 2600.0};
inline constexpr double kSandRadius = 227.5e-6 / 2.0;

/// The effective quantities of a contact.
struct HertzPair {
    double radius;  // R*
    double mass;    // m*
    double modulus; // E*
    double shear;   // G*

    static HertzPair equal_spheres(const Solid& solid, double radius) {
        const HertzPair wall = on_rigid_wall(solid, radius);
        return {0.5 * radius, 0.5 * wall.mass, 0.5 * wall.modulus, 0.5 * wall.shear};
    }
    static HertzPair on_rigid_wall(const Solid& solid, double radius) {
        return {radius, solid.mass(radius), solid.young / (1.0 - solid.poisson * solid.poisson), solid.shear() / (2.0 - solid.poisson)};
    }

    /// K of F = K overlap^1.5.
    double stiffness() const { return 4.0 / 3.0 * modulus * std::sqrt(radius); }
    double contact_radius(double overlap) const { return std::sqrt(radius * overlap); }
    double tangential_stiffness(double overlap) const { return 8.0 * shear * contact_radius(overlap); }
    double overlap_under(double force) const { return std::pow(force / stiffness(), 2.0 / 3.0); }
    /// Elastic impact at a closing speed.
    double largest_overlap(double speed) const { return std::pow(15.0 * mass * speed * speed / (16.0 * modulus * std::sqrt(radius)), 0.4); }
    double largest_force(double speed) const { return stiffness() * std::pow(largest_overlap(speed), 1.5); }
    /// 2 largest_overlap / speed times the integral of dx / sqrt(1 - x^(5/2)) from 0 to 1; with the largest overlap written
    /// out this is the 2.868 (m*^2 / (R* E*^2 v))^(1/5) of physics.md.
    double duration(double speed) const {
        const double factor = 0.8 * std::sqrt(kPi) * std::tgamma(0.4) / std::tgamma(0.9);
        return factor * largest_overlap(speed) / speed;
    }
};

/// Damping ratio of an unclipped contact of restitution e ("attractive").
inline double attractive_damping_ratio(double restitution) {
    const double l = std::log(restitution);
    return -l / std::hypot(kPi, l);
}

/// Restitution of the oscillator whose contact ends when the force would attract (physics.md section 2).
inline double clipped_restitution(double zeta) {
    if (zeta == 1.0) return std::exp(-2.0);
    if (zeta < 1.0) {
        const double s = std::sqrt(1.0 - zeta * zeta);
        return std::exp(-zeta / s * (kPi - std::atan2(2.0 * zeta * s, 1.0 - 2.0 * zeta * zeta)));
    }
    const double q = std::sqrt(zeta * zeta - 1.0);
    return std::exp(-zeta / q * std::log((zeta + q) / (zeta - q)));
}

/// Its inverse, by bisection; clipped_restitution falls monotonically.
inline double clipped_damping_ratio(double restitution) {
    if (restitution >= 1.0) return 0.0;
    double lo = 0.0;
    double hi = 10.0;
    for (int i = 0; i < 200; ++i) {
        const double middle = 0.5 * (lo + hi);
        (clipped_restitution(middle) > restitution ? lo : hi) = middle;
    }
    return 0.5 * (lo + hi);
}

/// Speed of growth of an error that should fall with a power of the step: log(coarse/fine)/log(refinement).
inline double observed_order(double coarse_error, double fine_error, double refinement) {
    return std::log(std::fabs(coarse_error) / std::fabs(fine_error)) / std::log(refinement);
}

} // namespace talus::test
