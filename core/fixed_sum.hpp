// core/fixed_sum.hpp: sums without an order.
//
// A contribution is scaled by a power of two, rounded once to an integer, and added as an integer. Integer addition is
// associative, so tiles, threads and ranks may add in any order, and the internal forces of a system sum to zero exactly.
// The unit follows from a cap that no valid contact can pass: cap = 2^50 units. Beyond the cap the run stops with the pair
// named, since a force there means that grains stand in each other's centres.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/constants.hpp"

namespace talus::core {

/// A power of two and its inverse: value * scale = integer units.
struct FixedUnit {
    double unit = 1.0;
    double scale = 1.0;

    /// The unit for which `cap` is at most 2^50 units.
    static FixedUnit for_cap(double cap) {
        int exponent = 0;
        std::frexp(cap, &exponent); // cap <= 2^exponent
        return {std::ldexp(1.0, exponent - kCapBits), std::ldexp(1.0, kCapBits - exponent)};
    }
};

struct FixedUnits {
    FixedUnit force;       // N
    FixedUnit torque;      // N m; energies of a contact use it as well
    FixedUnit wall_torque; // N m about the origin: force times the extent of the domain

    /// @param force_cap [N]; @param radius_max [m]; @param extent [m] largest coordinate in the domain
    static FixedUnits make(double force_cap, double radius_max, double extent) {
        FixedUnits u;
        u.force = FixedUnit::for_cap(force_cap);
        u.torque = FixedUnit::for_cap(force_cap * radius_max);
        // |x Fy - y Fx| may be twice the product of the largest components.
        u.wall_torque = FixedUnit::for_cap(2.0 * force_cap * (extent > radius_max ? extent : radius_max));
        return u;
    }
};

/// The largest force cap that units have room for, with the radius and extent they were made with [N]; not below the cap of then.
inline double most_force(const FixedUnits& u, double radius_max, double extent) {
    return kCapUnits * std::min({u.force.unit, u.torque.unit / radius_max, 0.5 * u.wall_torque.unit / std::max(extent, radius_max)});
}

using Wide = __int128;

inline double to_double(Wide units, double unit) { return static_cast<double>(units) * unit; }

/// Round a value to units, ties to even, exact up to 2^62 units; for sums that are not in kernels.
inline Wide to_units(double value, double scale) { return static_cast<Wide>(std::nearbyint(value * scale)); }

} // namespace talus::core
