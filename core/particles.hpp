// core/particles.hpp: what a rank holds of a grain.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/types.hpp"
#include "core/vec3.hpp"

namespace talus::core {

/// What a contact reads (first 96 bytes), and what rides along. 128 bytes: two cache lines, loaded whole and transposed in
/// registers by the kernel; a gather per component is several times slower.
struct alignas(64) Particle {
    double position[3];         // m
    double radius;              // m
    double velocity[3];         // m/s; between phases of a step, at the half step
    double mass;                // kg
    double angular_velocity[3]; // rad/s
    std::uint64_t meta;         // material, group, colour: see below
    double listed_position[3];  // m, where the grain was when the candidate pairs were built, shifted along with its periodic wraps
    Label label;
};
static_assert(sizeof(Particle) == 128);

/// Four doubles, aligned for whole vector loads.
struct alignas(32) Quad {
    double v[4];
};

inline int material_of(const Particle& p) { return static_cast<int>(p.meta & 0xff); }
inline int group_of(const Particle& p) { return static_cast<int>(p.meta >> 8 & 0xff); }
inline int colour_of(const Particle& p) { return static_cast<int>(p.meta >> 16 & 0xff); }
/// Set while an insertion is being checked, so that it can be taken back.
inline constexpr std::uint64_t kNewGrain = std::uint64_t{1} << 63;
inline bool is_new(const Particle& p) { return (p.meta & kNewGrain) != 0; }
inline std::uint64_t make_meta(int material, int group, int colour) {
    return static_cast<std::uint64_t>(material) | static_cast<std::uint64_t>(group) << 8 |
           static_cast<std::uint64_t>(colour) << 16;
}

/// Force and torque of a grain as integers: see fixed_sum.hpp.
struct alignas(64) ForceSum {
    std::int64_t force[3];
    std::int64_t pad0;
    std::int64_t torque[3];
    std::int64_t pad1;
};
static_assert(sizeof(ForceSum) == 64);

inline void operator+=(ForceSum& a, const ForceSum& b) {
    for (int c = 0; c < 3; ++c) {
        a.force[c] += b.force[c];
        a.torque[c] += b.torque[c];
    }
}

using Reference = std::array<double, 3>; // m, origin of the displacement field; shifted along with periodic wraps

/// How a group of grains moves.
struct GroupMotion {
    enum class Mode : std::int32_t { free = 0, frozen = 1, driven = 2 };
    Mode mode = Mode::free;
    double velocity[3] = {0, 0, 0};
    double angular_velocity[3] = {0, 0, 0};
};
using GroupTable = std::array<GroupMotion, kMaxGroups>;

} // namespace talus::core
