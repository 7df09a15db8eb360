// core/constants.hpp: every number that a formula needs, with its source.
#pragma once

#include <cstdint>

namespace talus::core {

inline constexpr double kPi = 3.14159265358979323846;

/// Solid sphere: moment of inertia / (m R^2).
inline constexpr double kSphereInertia = 0.4;
/// Sphere rolling about its contact point: (I + m R^2)/(m R^2), in the rolling inertia of Ai et al. (2011).
inline constexpr double kRollingInertia = 1.0 + kSphereInertia;
/// Rolling stiffness of type C: kr = 2.25 kn mu_r^2 R_r^2 (Ai et al. 2011, eq. 19 with their model C).
inline constexpr double kRollingStiffness = 2.25;

/// Rayleigh wave speed fit: dt = pi R sqrt(rho/G) / (0.1631 nu + 0.8766) (Li, Xu and Thornton 2005).
inline constexpr double kRayleighSlope = 0.1631;
inline constexpr double kRayleighOffset = 0.8766;

/// A pair force at the cap is 2^50 units: the conversion of a double to an integer by adding a magic number holds below
/// 2^51, and one bit is kept so that the cap test itself is exact.
inline constexpr int kCapBits = 50;
inline constexpr double kCapUnits = 1125899906842624.0; // 2^50
/// 2^63 / 2^50: contributions at the cap that a 64-bit sum can hold.
inline constexpr double kMaxContributions = 8192.0;

/// Below every square of a force, velocity or spin that matters, above zero: divisions by a vanishing length.
inline constexpr double kTiny = 1e-300;

} // namespace talus::core
