#include "core/contact_history.hpp"

#include <cstring>

namespace talus::core {

namespace {
// Tiles count and fill at once, and a pair across tiles has an entry on both sides: the cursor of a grain is shared.
std::uint32_t next(std::uint32_t& cursor) { return std::atomic_ref(cursor).fetch_add(1, std::memory_order_relaxed); }
} // namespace

void ContactLayout::count(const Tile& tile) {
    each_touching(tile, [&](LocalIndex a, LocalIndex b, Label, const ContactList&, std::uint32_t) {
        next(store_.first[a + 1]);
        if (b < n_owned_) next(store_.first[b + 1]);
    });
}

void ContactLayout::allocate(const std::vector<Tile>& tiles) {
    for (std::size_t g = 1; g < store_.first.size(); ++g) store_.first[g] += store_.first[g - 1];
    store_.entries.resize(store_.first.back());
    first_row_of_tile_.assign(1, 0);
    for (const Tile& t : tiles) {
        std::uint32_t n = 0;
        const auto count_bits = [&](const ContactList& list) {
            for (const std::uint8_t bits : list.touching) n += static_cast<std::uint32_t>(std::popcount(bits));
        };
        count_bits(t.pairs);
        for (const auto& w : t.walls) count_bits(w);
        first_row_of_tile_.push_back(first_row_of_tile_.back() + n);
    }
    store_.rows.resize(static_cast<std::size_t>(first_row_of_tile_.back()) * store_.history_quads);
}

void ContactLayout::fill(int tile_index, const Tile& tile) {
    std::uint32_t row = first_row_of_tile_[tile_index];
    // first[g] serves as cursor; finish() moves it back.
    each_touching(tile, [&](LocalIndex a, LocalIndex b, Label wall, const ContactList& list, std::uint32_t contact) {
        const Label partner = wall >= 0 ? wall : particles_[b].label;
        store_.entries[next(store_.first[a])] = {partner, row};
        if (b < n_owned_) store_.entries[next(store_.first[b])] = {particles_[a].label, row};
        list.get_history(contact, store_.values(row++));
    });
}

void ContactLayout::finish() {
    for (std::size_t g = store_.first.size() - 1; g > 0; --g) store_.first[g] = store_.first[g - 1];
    store_.first[0] = 0;
}

void inherit_histories(const ContactStore& store, const std::vector<std::uint32_t>& slot_of, const std::vector<Particle>& particles, Tile& tile) {
    struct Match {
        std::uint32_t candidate;
        const ContactEntry* entry;
    };
    std::vector<Match> matches;
    const auto inherit = [&](ContactList& list, auto partner) {
        matches.clear();
        for (std::uint32_t k = 0; k < list.n_candidates; ++k)
            if (const ContactEntry* e = store.find(slot_of[tile.index_of[list.candidates[k].own()]], partner(list.candidates[k]))) matches.push_back({k, e});
        // Room for those that will touch before the next rebuild, too.
        list.reserve_contacts(matches.size() + matches.size() / 16);
        std::uint32_t kept = matches.empty() ? list.n_candidates : matches.front().candidate, next = kept;
        for (const Match& m : matches) {
            while (next < m.candidate) list.candidates[kept++] = list.candidates[next++];
            list.set_touching(list.add_contact(list.candidates[next++]), store.values(m.entry->row));
        }
        while (next < list.n_candidates) list.candidates[kept++] = list.candidates[next++];
        list.n_candidates = kept;
    };
    inherit(tile.pairs, [&](CandidatePair p) { return particles[tile.index_of[p.partner()]].label; });
    for (std::size_t w = 0; w < tile.walls.size(); ++w) inherit(tile.walls[w], [&](CandidatePair) { return kWallLabel + static_cast<Label>(w); });
}

} // namespace talus::core
