// core/philox.hpp: counter-based random numbers (Philox4x32-10, Salmon et al. 2011, by Random123): a number is a function of
// seed, stream and item, so it hangs neither on ranks nor on order.
#pragma once

#include <array>
#include <cstdint>

#include <Random123/philox.h>

namespace talus::core {

/// Every stream of random numbers, in one list; numbers never change.
enum class RandomStream : std::uint32_t { packing = 1, random_cuts = 2 };

/// Four numbers in [0, 1), exact multiples of 2^-32.
inline std::array<double, 4> random_unit(std::uint64_t seed, RandomStream stream, std::uint64_t item) {
    using Philox = r123::Philox4x32;
    Philox::ctr_type counter{{static_cast<std::uint32_t>(item), static_cast<std::uint32_t>(item >> 32), static_cast<std::uint32_t>(stream), 0u}};
    Philox::key_type key{{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}};
    const auto r = Philox{}(counter, key);
    constexpr double kUnit = 1.0 / 4294967296.0;
    return {r[0] * kUnit, r[1] * kUnit, r[2] * kUnit, r[3] * kUnit};
}

} // namespace talus::core
