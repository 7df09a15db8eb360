// core/contact_probe.hpp: one contact looked at from outside a step: its force now, and the energy it stores. Calls the same law
// as the kernels; changes nothing.
#pragma once

#include "core/tile.hpp"

namespace talus::core {

struct ContactView {
    Label i = 0, j = 0;            // i < j; j = kWallLabel + wall at a wall
    LocalIndex particle_i = 0, particle_j = 0; // j: not set at a wall
    Vec3d normal{0, 0, 0};         // from j to i
    Vec3d branch{0, 0, 0};         // m, from j's centre (or the wall) to i's
    Vec3d force{0, 0, 0};          // N on i, with the velocities of now and no step of history
    double overlap = 0;            // m
    double smaller_radius = 0;     // m
    bool sliding = false;          // in the last step
    double elastic_normal = 0, elastic_tangential = 0, elastic_rolling = 0; // J
};

/// A contact of the list that touches, of grains or with a wall.
using PairProbe = ContactView (*)(const ForceContext&, const TileIds&, const ContactList&, std::uint32_t contact);
using WallProbe = ContactView (*)(const ForceContext&, const WallPlane&, int wall, const TileIds&, const ContactList&, std::uint32_t contact);

struct ProbeSet {
    PairProbe pair;
    WallProbe wall;
};
ProbeSet select_probes(const Laws& laws);

} // namespace talus::core
