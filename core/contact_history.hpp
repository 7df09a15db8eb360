// core/contact_history.hpp: contact histories while lists change, found by the partner's label: the way in which they survive
// rebuilds, rebalances, migrations and restarts.
// Source   Nishiura, Furuichi and Sakaguchi, Figs. 1 and 8: before a list changes every grain's pair data is stored beside the
//          serial number of the other grain; after it, each candidate pair looks its partner up in the grain's short list.
//          Here the orientation of a pair follows the labels, so rows never change sign; and histories stay in the lists
//          that are given up until the new ones take them: a copy of all is never made.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "core/error.hpp"
#include "core/tile.hpp"

namespace talus::core {

/// Where a history stands: contact `at` of a list, or row `at` of the grains that came when there is no list.
struct HistoryPlace {
    static constexpr std::uint32_t kNowhere = 0xffffffffu;
    const ContactList* list = nullptr;
    std::uint32_t at = kNowhere;

    bool found() const { return at != kNowhere; }
};

/// Contacts of a rank's grains between lists. A grain that was here when the lists were given up has its place among them as its
/// slot; those that came since (from other ranks, a checkpoint, the host) have the slots behind them.
struct ContactStore {
    int history_doubles = 0;
    // Grains that were here. The tiles belong to someone else; what is asked of a tile needs its index (index_contacts).
    std::span<Tile> tiles;
    std::vector<Label> labels; // of the grains and ghosts that the tiles name
    LocalIndex n_grains = 0;   // without ghosts
    // Grains that came: their contacts, with both grains' copies of a row.
    std::vector<std::uint32_t> first{0}; // [grains + 1] contacts before each
    std::vector<Label> partners;
    std::vector<double> rows; // history_doubles a contact

    /// Add a grain that came, with its contacts. @param rows_of_grain  history_doubles a partner @return its slot
    std::uint32_t append(const Label* partners_of_grain, const double* rows_of_grain, std::uint32_t n) {
        partners.insert(partners.end(), partners_of_grain, partners_of_grain + n);
        rows.insert(rows.end(), rows_of_grain, rows_of_grain + static_cast<std::size_t>(n) * static_cast<std::size_t>(history_doubles));
        first.push_back(static_cast<std::uint32_t>(partners.size()));
        return n_grains + static_cast<std::uint32_t>(first.size()) - 2;
    }
    /// The tile of a grain that was here.
    Tile& tile_of(std::uint32_t slot) const {
        return *(std::upper_bound(tiles.begin(), tiles.end(), slot, [](std::uint32_t v, const Tile& t) { return v < t.first; }) - 1);
    }
    /// Index what each(slot) looks at.
    void open(std::uint32_t slot) const;
    /// visit(partner, place) for every contact of a grain, partners in no order.
    template <class Visit>
    void each(std::uint32_t slot, Visit visit) const;
    void get(const HistoryPlace& p, double* row) const {
        if (p.list != nullptr)
            p.list->get_history(p.at, row);
        else
            std::copy_n(rows.data() + static_cast<std::size_t>(p.at) * static_cast<std::size_t>(history_doubles), history_doubles, row);
    }
    /// Every contact starts anew, with histories of so many doubles.
    void void_histories(int doubles);
    /// The memory of labels is kept; contacts of grains that came may be those of a whole checkpoint.
    void clear() {
        tiles = {};
        labels.clear();
        n_grains = 0;
        first = {0};
        partners = {};
        rows = {};
    }
    std::size_t bytes() const {
        return (labels.capacity() + partners.capacity()) * sizeof(Label) + first.capacity() * sizeof(std::uint32_t) + rows.capacity() * sizeof(double);
    }
};

/// Make a tile's index by grain, if it has none. @param labels of the grains and ghosts that it names
void index_contacts(const std::vector<Label>& labels, Tile& tile);

/// Scratch of one worker.
struct InheritScratch {
    /// A grain of the new tile: its label, and where its contacts were.
    struct Grain {
        Label label;
        const Tile* tile;   // NULL when it came since, or is a ghost
        std::uint32_t id;   // in that tile; or its slot
    };
    struct Match {
        CandidatePair pair;
        HistoryPlace place;
    };
    std::vector<Grain> grains; // by tile-local id
    std::vector<Match> matches;
};

/// Make a tile's lists: near pairs that were in touch become contacts, with their histories, the others candidates. The tiles of the
/// store that its grains and those of its border were in, and the neighbours of its own grains' tiles there, must be indexed.
/// @param slot_of  owned grain -> slot in the store; near  is used up
void inherit_histories(const ContactStore& store, const std::vector<std::uint32_t>& slot_of, const std::vector<Particle>& particles, NearPairs& near, Tile& tile, InheritScratch& scratch);

// ---- implementation ----

/// A contact of an indexed tile by its number.
struct NumberedContact {
    HistoryPlace place;
    Label wall = -1; // or that of the wall
};
inline NumberedContact contact_by_number(const Tile& tile, std::uint32_t number) {
    if (number < tile.pairs.n_contacts) return {{&tile.pairs, number}, -1};
    number -= tile.pairs.n_contacts;
    std::size_t w = 0;
    while (number >= tile.walls[w].n_contacts) number -= tile.walls[w++].n_contacts;
    return {{&tile.walls[w], number}, kWallLabel + static_cast<Label>(w)};
}
/// The label of whom grain `id` touches there.
inline Label partner_of(const std::vector<Label>& labels, const Tile& tile, TileLocal id, const NumberedContact& c) {
    if (c.wall >= 0) return c.wall;
    const CandidatePair pair = c.place.list->contacts[c.place.at];
    return labels[tile.index_of[pair.i == id ? pair.j : pair.i]];
}
/// visit(partner, place) for the contacts of grain `id` in an indexed tile.
template <class Visit>
void each_in_tile(const std::vector<Label>& labels, const Tile& tile, TileLocal id, Visit visit) {
    for (std::uint32_t e = tile.by_grain.first[id]; e < tile.by_grain.first[id + 1]; ++e) {
        const NumberedContact c = contact_by_number(tile, tile.by_grain.number[e]);
        visit(partner_of(labels, tile, id, c), c.place);
    }
}

template <class Visit>
void ContactStore::each(std::uint32_t slot, Visit visit) const {
    if (slot >= n_grains) {
        for (std::uint32_t e = first[slot - n_grains]; e < first[slot - n_grains + 1]; ++e) visit(partners[e], HistoryPlace{nullptr, e});
        return;
    }
    const Tile& own = tile_of(slot);
    each_in_tile(labels, own, slot - own.first, visit);
    // Pairs across tiles stand in one of the two.
    for (const IncomingSums& in : own.incoming) {
        const Tile& other = tiles[static_cast<std::size_t>(in.from_tile)];
        TALUS_CHECK(!other.by_grain.first.empty());
        const auto from = other.index_of.begin() + in.first, to = from + in.count, at = std::lower_bound(from, to, slot);
        if (at != to && *at == slot) each_in_tile(labels, other, static_cast<TileLocal>(at - other.index_of.begin()), visit);
    }
}

} // namespace talus::core
