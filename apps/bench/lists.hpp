// apps/bench/lists.hpp: what stands in the lists, and the bytes that it takes. The one place here that knows how a list is stored.
#pragma once

#include "runtime/engine_state.hpp"

namespace talus::bench {

struct ListCounts {
    double candidates = 0.0; // all pairs that are listed
    double searched = 0.0;   // those of them that every force evaluation asks whether they touch
    double contacts = 0.0;   // touching

    double standing() const { return candidates - searched; } // have a history row
    void operator+=(const ListCounts& b) {
        candidates += b.candidates;
        searched += b.searched;
        contacts += b.contacts;
    }
};

inline ListCounts count_list(const core::ContactList& list) {
    return {static_cast<double>(list.n_contacts) + list.n_candidates, static_cast<double>(list.n_candidates), static_cast<double>(list.n_touching())};
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
        for (const core::ContactList& list : tile.walls) n += count_list(list);
    return n;
}

/// A pair, the touching bit of a contact, and one grain's entry for a contact in an index (core::ContactsByGrain).
inline constexpr double kPairBytes = sizeof(core::CandidatePair), kBitBytes = 1.0 / 8.0, kEntryBytes = 2.0 * sizeof(std::uint32_t);

// Bytes moved of lists, by the model of traffic.hpp; `row`: bytes of a history row.

/// By a force evaluation: pairs are read, bits and rows of contacts read and written.
inline double force_bytes(const ListCounts& n, double row) { return n.candidates * kPairBytes + n.standing() * 2.0 * (kBitBytes + row); }
/// By indexing contacts grain by grain: they are passed twice, and both grains of each get an entry.
inline double index_bytes(const ListCounts& n) { return n.standing() * 2.0 * (kPairBytes + kBitBytes) + n.contacts * 2.0 * kEntryBytes; }
/// By writing a list anew: pairs, bits of contacts, and rows out of the old list.
inline double list_bytes(const ListCounts& n, double row) { return n.candidates * kPairBytes + n.contacts * (kBitBytes + 2.0 * row); }

} // namespace talus::bench
