// apps/bench/traffic.hpp: bytes that phases move, by a model of what they must: each array that a phase works on is read or written once from
// beginning to end, records by whole cache lines; what a tile uses again and again (gathered grains, columns of the search,
// batches) stays in cache and does not count; nor does what a cache fetches in order to write (as in STREAM). Sizes and numbers are the engine's own.
#pragma once

#include "runtime/engine_state.hpp"

namespace talus::bench {

/// Bytes over all grains: of one step, or of one rebuild.
struct Traffic {
    double force = 0, integrate = 0;     // a step
    double binning = 0, pair_build = 0;  // a rebuild
};
/// With the lists as they stand; one rank. halo_exchange and rebalance move nothing there.
Traffic traffic(const runtime::EngineState& state);

} // namespace talus::bench
