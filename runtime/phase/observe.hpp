// runtime/phase/observe.hpp: what can be asked of a state. Sums have no order: same bits on any ranks and threads. Nothing changes.
#pragma once

#include <functional>

#include "core/contact_probe.hpp"
#include "core/state_digest.hpp"
#include "runtime/engine_state.hpp"

namespace talus::runtime {

struct Observation {
    std::int64_t contacts = 0, wall_contacts = 0, sliding = 0; // over all ranks
    double kinetic = 0.0, rotational = 0.0;                    // J
    double elastic_normal = 0.0, elastic_tangential = 0.0, elastic_rolling = 0.0;
    double gravity = 0.0;                                      // J, potential
    double friction = 0.0, damping = 0.0, rolling = 0.0;       // J, dissipated
    double max_speed = 0.0;
    double unbalanced = 0.0;
    double max_overlap = 0.0; // of the smaller radius, contacts of grains
};
/// [collective]
Observation observe(EngineState& s);

/// [collective]
core::Digest digest(EngineState& s);

struct ContactRow {
    core::Label i, j; // j: core::kWallLabel + wall at a wall
    core::Vec3d value; // as asked for
};
/// Contacts whose grain i this rank owns, by labels, each with what `value` makes of it. Ghosts must be up to date.
std::vector<ContactRow> list_contacts(EngineState& s, const std::function<core::Vec3d(const core::ContactView&)>& value);
/// The middle of a contact's overlap, within the domain [m].
core::Vec3d contact_point(const EngineState& s, const core::ContactView& c);

struct WallObservation {
    core::Vec3d force, torque; // on the wall
    std::int64_t contacts;
};
/// [collective]
WallObservation observe_wall(EngineState& s, int wall);

struct StressObservation {
    double stress[9];
    double solid_fraction, coordination;
};
/// Love-Weber stress of a box, compression negative. [collective]
StressObservation observe_stress(EngineState& s, const double (&lo)[3], const double (&hi)[3]);

/// Integer sum of grain-on-grain forces: zero. [collective]
void internal_force_sum(EngineState& s, std::int64_t (&out)[3]);

} // namespace talus::runtime
