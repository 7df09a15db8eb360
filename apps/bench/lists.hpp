// apps/bench/lists.hpp: how many candidates and contacts stand in the lists. The one place here that knows how a list is stored.
#pragma once

#include "runtime/engine_state.hpp"

namespace talus::bench {

struct ListCounts {
    double candidates = 0.0, contacts = 0.0;

    void operator+=(const ListCounts& b) {
        candidates += b.candidates;
        contacts += b.contacts;
    }
};

inline ListCounts count_list(const core::ContactListData& list) {
    ListCounts n{static_cast<double>(list.count), 0.0};
    for (std::uint32_t k = 0; k < list.count; ++k) n.contacts += list.touches(k) ? 1.0 : 0.0;
    return n;
}

/// Of grains on grains, all tiles of a rank.
inline ListCounts count_pairs(const runtime::EngineState& s) {
    ListCounts n;
    for (const core::Tile& tile : s.sub.tiles) n += count_list(tile.pairs);
    return n;
}
/// Of grains on walls.
inline ListCounts count_walls(const runtime::EngineState& s) {
    ListCounts n;
    for (const core::Tile& tile : s.sub.tiles)
        for (const core::ContactListData& list : tile.walls) n += count_list(list);
    return n;
}

} // namespace talus::bench
