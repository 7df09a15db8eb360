// core/state_digest.hpp: an order-free digest of a state: the sum, modulo 2^128 by halves, of a hash of each grain, contact and
// wall. The same from any decomposition, so every parallel defect shows as a failed equality.
#pragma once

#include <cstdint>
#include <cstring>

#ifndef XXH_INLINE_ALL
#define XXH_INLINE_ALL
#endif
#include <xxhash.h>

#include "core/particles.hpp"
#include "core/tile.hpp"

namespace talus::core {

struct Digest {
    std::uint64_t lo = 0, hi = 0;

    /// Add the hash of some plain bytes.
    void add(const void* data, std::size_t bytes) {
        const XXH128_hash_t h = XXH3_128bits(data, bytes);
        lo += h.low64;
        hi += h.high64;
    }
    void add_grain(const Particle& p, const ForceSum& s) {
        struct {
            Label label;
            double state[11];
            std::uint64_t meta;
            std::int64_t sums[6];
        } item;
        item.label = p.label;
        std::memcpy(item.state, p.position, sizeof item.state); // position, radius, velocity, mass, angular velocity
        item.meta = p.meta;
        std::memcpy(item.sums, s.force, 3 * sizeof(std::int64_t));
        std::memcpy(item.sums + 3, s.torque, 3 * sizeof(std::int64_t));
        add(&item, sizeof item);
    }
    /// A contact, by the owner of the smaller label; j a label or a wall's.
    void add_contact(Label i, Label j, const double* row, int doubles) {
        struct {
            Label i, j;
            double row[8];
        } item{i, j, {0, 0, 0, 0, 0, 0, 0, 0}};
        if (doubles > 0) std::memcpy(item.row, row, static_cast<std::size_t>(doubles) * sizeof(double));
        add(&item, sizeof item);
    }
};

} // namespace talus::core
