// apps/bench/lists.hpp: what stands in the lists, and the bytes that it takes. The one place here that knows how a list is stored.
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

/// A candidate and its touching bit.
inline constexpr double kCandidateBytes = sizeof(core::CandidatePair), kBitBytes = 1.0 / 8.0;

// Bytes moved of lists, by the model of traffic.hpp; `row`: bytes of a history row.

/// By a force evaluation: candidates are read, bits read and written, rows of contacts read and written.
inline double force_bytes(const ListCounts& n, double row) { return n.candidates * (kCandidateBytes + 2.0 * kBitBytes) + n.contacts * 2.0 * row; }
/// By laying contacts out grain by grain: the list is read twice, rows are copied.
inline double layout_bytes(const ListCounts& n, double row) { return n.candidates * 2.0 * (kCandidateBytes + kBitBytes) + n.contacts * 2.0 * row; }
/// By writing a list anew: candidates, bits, and a row for every candidate.
inline double list_bytes(const ListCounts& n, double row) { return n.candidates * (kCandidateBytes + kBitBytes + row); }

} // namespace talus::bench
