// core/domain.hpp: the box of the simulation, closed or periodic on each axis.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/particles.hpp"

namespace talus::core {

struct Domain {
    double lo[3] = {0, 0, 0};
    double hi[3] = {0, 0, 0};
    bool periodic[3] = {false, false, false};

    double length(int axis) const { return hi[axis] - lo[axis]; }
    /// Largest magnitude of a coordinate.
    double extent() const {
        double e = 0.0;
        for (int a = 0; a < 3; ++a) e = std::max({e, std::fabs(lo[a]), std::fabs(hi[a])});
        return e;
    }
};

/// Period and its inverse on each axis, zero on closed ones: then `minimum_image` leaves a component unchanged to the bit.
struct Periods {
    double length[3] = {0, 0, 0};
    double inverse[3] = {0, 0, 0};

    explicit Periods(const Domain& d) {
        for (int a = 0; a < 3; ++a) {
            if (!d.periodic[a]) continue;
            length[a] = d.length(a);
            inverse[a] = 1.0 / length[a];
        }
    }
};

/// The nearest image of a difference of positions. Odd in `d` to the bit, so both sides of a pair see opposite vectors.
template <class V>
inline Vec3<V> minimum_image(const Periods& p, const Vec3<V>& d) {
    const auto one = [&](V x, int a) {
        return fnma(splat<V>(p.length[a]), nearest(x * splat<V>(p.inverse[a])), x);
    };
    return {one(d.x, 0), one(d.y, 1), one(d.z, 2)};
}

/// Of grains that stand so near together that no image is nearer: the same difference, to the bit, without the search.
struct NoPeriods {};
template <class V>
inline Vec3<V> minimum_image(NoPeriods, const Vec3<V>& d) {
    return d;
}
/// Differences up to this share of a period have no nearer image, whatever is rounded.
inline constexpr double kOwnImage = 0.49;

/// Bring a position back into the box on periodic axes, and the reference with it; every step, from the state alone.
inline void wrap(const Domain& d, double (&position)[3], Reference& reference) {
    for (int a = 0; a < 3; ++a) {
        if (!d.periodic[a]) continue;
        const double length = d.length(a);
        if (position[a] >= d.hi[a]) {
            position[a] -= length;
            reference[a] -= length;
        } else if (position[a] < d.lo[a]) {
            position[a] += length;
            reference[a] += length;
        }
    }
}

} // namespace talus::core
