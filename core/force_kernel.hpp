// core/force_kernel.hpp: forces of one tile. Candidates that touch become contacts; then W contacts at a time, where they stand:
// load, transpose, law, history, convert to integers, add.
//
// Bits     a pair's force is one pure function of the two grains' records and the pair's history, evaluated with i = the grain
//          with the smaller label, at any width; sums are integers. So neither the order nor the width shows.
// Threads  none here: a call writes only what belongs to its tile (sums and the list).
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/contact_list.hpp"
#include "core/domain.hpp"
#include "core/fixed_sum.hpp"
#include "core/law/contact.hpp"
#include "core/material.hpp"

namespace talus::core {

/// What contacts read of a tile's grains, by tile-local id, copied together before the forces: the records of a tile lie in runs
/// all over the rank's, and reading each where it stands, pair by pair, waits for memory at every one.
struct TileGrains {
    std::vector<Quad> centre; // position [m], radius [m]
    std::vector<Quad> motion; // velocity [m/s], mass [kg]
    std::vector<Quad> spin;   // angular velocity [rad/s], meta
    int material = 0;         // of all of them, or -1 for several
    double extent[3] = {0, 0, 0}; // m, between the outermost centres

    /// Whether a pair of them may be nearer across a period.
    bool spans_images(const Periods& periods) const {
        bool any = false;
        for (int a = 0; a < 3; ++a) any = any || (periods.length[a] > 0.0 && !(extent[a] <= kOwnImage * periods.length[a]));
        return any;
    }
    void gather(const Particle* particles, const std::vector<LocalIndex>& index_of);
};

/// A plane as the kernel sees it.
struct WallPlane {
    Vec3d point, normal, velocity;
    int material = 0;
};

/// What all tiles of a rank share in one force evaluation.
struct ForceContext {
    Laws laws;
    Periods periods{Domain{}};
    FixedUnits units;
    double dt = 0.0;         // s; 0: forces only
    bool advance = true;     // write histories and heat; false for an evaluation outside a step (which contacts touch is always written)
    bool ledger = false;     // account dissipated energy
    int n_materials = 1;
    PairParameters pairs[kMaxMaterials][kMaxMaterials];
};

/// Whom the ids of a tile's lists mean.
struct TileIds {
    const Particle* particles = nullptr;  // of the rank: owned, then ghosts
    LocalIndex n_owned = 0;
    const LocalIndex* index_of = nullptr; // tile-local id -> particle
};

/// What a kernel works on.
struct TileForces : TileIds {
    const TileGrains* grains = nullptr; // gathered by the same ids
    ForceSum* sums = nullptr;           // one a tile-local id
};

/// What walls got from one tile, or in all.
struct WallSum {
    Wide force[3] = {0, 0, 0};  // force units, on the wall
    Wide torque[3] = {0, 0, 0}; // wall-torque units, about the origin
    std::int64_t contacts = 0;
};

/// Dissipated energy, torque units.
struct HeatSum {
    Wide friction = 0, damping = 0, rolling = 0;
};

/// A contact whose force or torque is above its cap or not a number.
struct CapBreach {
    bool found = false;
    Label i = 0, j = 0;
    double force = 0.0; // N
};

/// Widths that can be asked for: contacts at a time. Automatic is the widest that this build and processor have.
enum class KernelWidth { automatic = 0, scalar = 1, four = 4, eight = 8 };
bool has_width(KernelWidth width);

using PairKernel = void (*)(const ForceContext&, const TileForces&, ContactList&, HeatSum&, CapBreach&);
using WallKernel = void (*)(const ForceContext&, const WallPlane&, int wall, const TileForces&, ContactList&, WallSum&, HeatSum&, CapBreach&);

struct KernelSet {
    PairKernel pair;
    WallKernel wall;
};

/// The kernels for a combination of laws; refused combinations never come here (see laws_fault). A width that is not there is an error.
KernelSet select_kernels(const Laws& laws, bool ledger, KernelWidth width);

/// NULL, or what is wrong with a combination of laws.
const char* laws_fault(const Laws& laws);

} // namespace talus::core
