// core/force_kernel.hpp: forces of one tile. Two stages: filter the candidate pairs to touching ones and compact them;
// then W touching pairs at a time: load, transpose, law, history, convert to integers, add.
//
// Bits     a pair's force is one pure function of the two grains' records and the pair's history, evaluated with i = the grain
//          with the smaller label, at any width; sums are integers. So neither the order nor the width shows.
// Threads  none here: a call writes only the rows of its tile (sums, history, touching bits).
#pragma once

#include <cstdint>

#include "core/domain.hpp"
#include "core/fixed_sum.hpp"
#include "core/law/contact.hpp"
#include "core/material.hpp"

namespace talus::core {

/// A candidate pair as two tile-local ids. The top bit of `b` tells that b has the smaller label.
struct CandidatePair {
    TileLocal a;
    TileLocal b_flip;

    static constexpr TileLocal kFlip = 0x80000000u;
    TileLocal b() const { return b_flip & ~kFlip; }
    bool flipped() const { return (b_flip & kFlip) != 0; }
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
    bool advance = true;     // write histories and heat; false for an evaluation outside a step (touching bits are always written)
    bool ledger = false;     // account dissipated energy
    int n_materials = 1;
    PairParameters pairs[kMaxMaterials][kMaxMaterials];
};

/// How far ahead of its use a kernel asks for what a pair will need, in pairs.
inline constexpr std::uint32_t kFetchAhead = 24;

/// One tile's share of a list: candidates, one touching bit each, and history rows.
struct ContactList {
    const CandidatePair* pairs = nullptr; // padded to a multiple of 8 and by kFetchAhead
    std::uint8_t* touching = nullptr;     // one bit a pair: touched at the last evaluation; rows of others are void
    double* history = nullptr;            // history_doubles(laws) a pair, 32-byte aligned
    std::uint32_t count = 0;
};

struct TileForces {
    const Particle* particles = nullptr;        // of the rank: owned, then ghosts
    LocalIndex n_owned = 0;
    const LocalIndex* index_of = nullptr;       // tile-local id -> particle
    ForceSum* sums = nullptr;                   // one a tile-local id
    ContactList contacts;
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

/// Widths that can be asked for; automatic is the widest this machine has.
enum class KernelWidth { automatic = 0, scalar = 1, four = 4 };

using PairKernel = void (*)(const ForceContext&, const TileForces&, HeatSum&, CapBreach&);
using WallKernel = void (*)(const ForceContext&, const WallPlane&, int wall, const TileForces&, WallSum&, HeatSum&, CapBreach&);

struct KernelSet {
    PairKernel pair;
    WallKernel wall;
};

/// The kernels for a combination of laws; refused combinations never come here (see laws_fault).
KernelSet select_kernels(const Laws& laws, bool ledger, KernelWidth width);

/// NULL, or what is wrong with a combination of laws.
const char* laws_fault(const Laws& laws);

} // namespace talus::core
