// core/integrate.hpp: velocity Verlet with rotation, a tile at a time.
//
// A step is: half kick, drift, wrap, (walls move, lists and halo), force, half kick. The second half kick of a step and the
// first of the next touch the same memory, so one pass does both: finish, then begin. Between passes positions are those of
// the coming step and velocities stand at the half step.
#pragma once

#include "core/domain.hpp"
#include "core/fixed_sum.hpp"
#include "core/tile.hpp"

namespace talus::core {

struct IntegrateContext {
    Domain domain;
    FixedUnits units;
    GroupTable groups;
    double gravity[3] = {0, 0, 0}; // m/s^2
    double dt = 0.0;               // s
    bool finish = false;           // second half kick of a step
    bool begin = false;            // first half kick, drift and wrap of the next
};

/// Steps by which a decision to rebuild may come late; displacements are foreseen over this many.
inline constexpr double kForeseenSteps = 3.0;

/// Add the border rows that other tiles hold for this one.
void collect_border(const std::vector<Tile>& tiles, Tile& tile);

/// Integrate a tile's own grains; with `begin`, note their displacements and whether they are finite.
void integrate_tile(const IntegrateContext& c, Particle* particles, Reference* references, Tile& tile);

} // namespace talus::core
