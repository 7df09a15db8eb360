// core/contact_history.hpp: contact histories laid out per grain with the partner's label, the form in which they survive
// rebuilds, rebalances, migrations and restarts.
// Source   Nishiura, Furuichi and Sakaguchi, Figs. 1 and 8: before a list changes every grain's pair data is stored beside the
//          serial number of the other grain; after it, each candidate pair looks its partner up in the grain's short list.
//          Here the orientation of a pair follows the labels, so rows never change sign.
#pragma once

#include <atomic>
#include <bit>
#include <cstdint>
#include <vector>

#include "core/tile.hpp"

namespace talus::core {

/// One contact of a grain. Both grains of a pair have an entry; the row is shared where both live on this rank.
struct ContactEntry {
    Label partner;     // label of the other grain, or kWallLabel + wall
    std::uint32_t row; // into rows, in units of a history row
    std::uint32_t pad = 0;
};

struct ContactStore {
    int history_quads = 0;
    std::vector<std::uint32_t> first;  // [n_grains + 1] entries before each grain
    std::vector<ContactEntry> entries;
    std::vector<Quad> rows;

    const ContactEntry* find(std::uint32_t grain, Label partner) const {
        for (std::uint32_t e = first[grain]; e < first[grain + 1]; ++e)
            if (entries[e].partner == partner) return &entries[e];
        return nullptr;
    }
    /// Add a grain that arrived, with its contacts; its slot is the number of grains before. @param row history_quads a partner
    void append(const Label* partners, const Quad* partner_rows, std::uint32_t n) {
        const auto first_row = static_cast<std::uint32_t>(history_quads > 0 ? rows.size() / history_quads : 0);
        for (std::uint32_t k = 0; k < n; ++k) entries.push_back({partners[k], first_row + k});
        rows.insert(rows.end(), partner_rows, partner_rows + static_cast<std::size_t>(n) * history_quads);
        first.push_back(static_cast<std::uint32_t>(entries.size()));
    }
    const Quad* row(const ContactEntry& e) const { return rows.data() + static_cast<std::size_t>(e.row) * history_quads; }
    double* values(std::uint32_t row) { return reinterpret_cast<double*>(rows.data() + static_cast<std::size_t>(row) * history_quads); }
    const double* values(std::uint32_t row) const { return reinterpret_cast<const double*>(rows.data() + static_cast<std::size_t>(row) * history_quads); }
    void clear() { // memory is kept
        first.clear();
        entries.clear();
        rows.clear();
    }
    std::size_t bytes() const {
        return first.capacity() * sizeof(std::uint32_t) + entries.capacity() * sizeof(ContactEntry) + rows.capacity() * sizeof(Quad);
    }
};

/// Lay out the touching contacts of a rank's tiles. Three passes; the tile passes may run in any order and at once.
class ContactLayout {
public:
    ContactLayout(ContactStore& store, const std::vector<Particle>& particles, LocalIndex n_owned, int history_quads)
        : store_(store), particles_(particles), n_owned_(n_owned) {
        store_.history_quads = history_quads;
        store_.first.assign(static_cast<std::size_t>(n_owned) + 1, 0);
    }
    /// Pass 1, per tile.
    void count(const Tile& tile);
    /// Pass 2, once: sizes. @param tiles all of the rank
    void allocate(const std::vector<Tile>& tiles);
    /// Pass 3, per tile.
    void fill(int tile_index, const Tile& tile);
    /// Pass 4, once.
    void finish();

private:
    template <class Visit>
    void each_touching(const Tile& tile, Visit visit) const;

    ContactStore& store_;
    const std::vector<Particle>& particles_;
    LocalIndex n_owned_;
    std::vector<std::uint32_t> first_row_of_tile_;
};

/// Make contacts of the candidates of a tile's fresh lists that were in touch, with their histories. @param slot_of  grain -> place in the store
void inherit_histories(const ContactStore& store, const std::vector<std::uint32_t>& slot_of, const std::vector<Particle>& particles, Tile& tile);

// ---- implementation ----

template <class Visit>
void ContactLayout::each_touching(const Tile& tile, Visit visit) const {
    const auto list = [&](const ContactList& data, Label wall) {
        for (std::uint32_t k = 0; k < data.n_contacts; ++k) {
            if (!data.touches(k)) continue;
            const LocalIndex a = tile.index_of[data.contacts[k].own()];
            if (wall >= 0)
                visit(a, n_owned_, wall, data, k);
            else
                visit(a, tile.index_of[data.contacts[k].partner()], Label{-1}, data, k);
        }
    };
    list(tile.pairs, -1);
    for (std::size_t w = 0; w < tile.walls.size(); ++w) list(tile.walls[w], kWallLabel + static_cast<Label>(w));
}

} // namespace talus::core
