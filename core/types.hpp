// core/types.hpp: the index types. A label names a grain for ever and everywhere; a local index names a slot of one rank
// until the next list rebuild; a tile-local id names a slot of one tile.
#pragma once

#include <cstdint>

namespace talus::core {

using Label = std::int64_t;
using LocalIndex = std::uint32_t;
using TileLocal = std::uint32_t;

/// Labels at or above this value are not grains: kWallLabel + id names a wall in contact lists.
inline constexpr Label kWallLabel = Label{1} << 62;
inline constexpr int kMaxMaterials = 16;
inline constexpr int kMaxWalls = 32;
inline constexpr int kMaxGroups = 16;

} // namespace talus::core
