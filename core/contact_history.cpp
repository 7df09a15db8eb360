#include "core/contact_history.hpp"

#include <cstring>

namespace talus::core {

namespace {
// Tiles count and fill at once, and a pair across tiles has an entry on both sides: the cursor of a grain is shared.
std::uint32_t next(std::uint32_t& cursor) { return std::atomic_ref(cursor).fetch_add(1, std::memory_order_relaxed); }
} // namespace

void ContactLayout::count(const Tile& tile) {
    each_touching(tile, [&](LocalIndex a, LocalIndex b, Label, const ContactListData&, std::uint32_t) {
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
        const auto count_bits = [&](const ContactListData& d) {
            for (const std::uint8_t bits : d.touching) n += static_cast<std::uint32_t>(std::popcount(bits));
        };
        count_bits(t.pairs);
        for (const auto& w : t.walls) count_bits(w);
        first_row_of_tile_.push_back(first_row_of_tile_.back() + n);
    }
    store_.rows.resize(static_cast<std::size_t>(first_row_of_tile_.back()) * store_.history_quads);
}

void ContactLayout::fill(int tile_index, const Tile& tile) {
    std::uint32_t row = first_row_of_tile_[tile_index];
    const int quads = store_.history_quads;
    // first[g] serves as cursor; finish() moves it back.
    each_touching(tile, [&](LocalIndex a, LocalIndex b, Label wall, const ContactListData& data, std::uint32_t k) {
        const Label partner = wall >= 0 ? wall : particles_[b].label;
        store_.entries[next(store_.first[a])] = {partner, row};
        if (b < n_owned_) store_.entries[next(store_.first[b])] = {particles_[a].label, row};
        for (int q = 0; q < quads; ++q)
            store_.rows[static_cast<std::size_t>(row) * quads + q] = data.history[static_cast<std::size_t>(k) * quads + q];
        ++row;
    });
}

void ContactLayout::finish() {
    for (std::size_t g = store_.first.size() - 1; g > 0; --g) store_.first[g] = store_.first[g - 1];
    store_.first[0] = 0;
}

void inherit_histories(const ContactStore& store, const std::vector<std::uint32_t>& slot_of, const std::vector<Particle>& particles, Tile& tile) {
    const int quads = store.history_quads;
    const auto take = [&](ContactListData& data, std::uint32_t k, LocalIndex a, Label partner) {
        const ContactEntry* e = store.find(slot_of[a], partner);
        if (e == nullptr) return;
        data.touching[k / 8] = static_cast<std::uint8_t>(data.touching[k / 8] | 1u << (k % 8));
        for (int q = 0; q < quads; ++q) data.history[static_cast<std::size_t>(k) * quads + q] = store.row(*e)[q];
    };
    for (std::uint32_t k = 0; k < tile.pairs.count; ++k) {
        const CandidatePair p = tile.pairs.pairs[k];
        take(tile.pairs, k, tile.index_of[p.own()], particles[tile.index_of[p.partner()]].label);
    }
    for (std::size_t w = 0; w < tile.walls.size(); ++w)
        for (std::uint32_t k = 0; k < tile.walls[w].count; ++k)
            take(tile.walls[w], k, tile.index_of[tile.walls[w].pairs[k].i], kWallLabel + static_cast<Label>(w));
}

} // namespace talus::core
