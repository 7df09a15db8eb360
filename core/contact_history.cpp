#include "core/contact_history.hpp"

#include <bit>

#include "core/error.hpp"
#include "core/simd.hpp"

namespace talus::core {

namespace {

std::uint32_t key_of(Label label) { return static_cast<std::uint32_t>(label); }

/// visit(number, list, contact, label of the wall or -1) for the touching contacts of a tile.
template <class Visit>
void each_touching(const Tile& tile, Visit visit) {
    std::uint32_t before = 0;
    const auto list = [&](const ContactList& contacts, Label wall) {
        for (std::uint32_t octet = 0; octet < contacts.touching.size(); ++octet)
            for (unsigned bits = contacts.touching[octet]; bits != 0; bits &= bits - 1) {
                const std::uint32_t k = 8 * octet + static_cast<std::uint32_t>(std::countr_zero(bits));
                visit(before + k, contacts, k, wall);
            }
        before += contacts.n_contacts;
    };
    list(tile.pairs, -1);
    for (std::size_t w = 0; w < tile.walls.size(); ++w) list(tile.walls[w], kWallLabel + static_cast<Label>(w));
}

/// The contact of grain `id` with a partner in an indexed tile.
inline HistoryPlace find_in_tile(const std::vector<Label>& labels, const Tile& tile, TileLocal id, Label partner) {
    const std::uint32_t from = tile.by_grain.first[id], to = tile.by_grain.first[id + 1];
    const Word8 key = Word8{} + static_cast<std::int32_t>(key_of(partner));
    for (std::uint32_t e = from; e < to; e += 8) {
        unsigned bits = bits_of_words(load_any(&tile.by_grain.key[e]) == key);
        if (to - e < 8) bits &= (1u << (to - e)) - 1u;
        for (; bits != 0; bits &= bits - 1) {
            const NumberedContact c = contact_by_number(tile, tile.by_grain.number[e + static_cast<std::uint32_t>(std::countr_zero(bits))]);
            if (partner_of(labels, tile, id, c) == partner) return c.place;
        }
    }
    return {};
}

HistoryPlace find_among_all(const ContactStore& store, std::uint32_t slot, Label partner) {
    HistoryPlace found;
    store.each(slot, [&](Label label, const HistoryPlace& place) {
        if (label == partner) found = place;
    });
    return found;
}

} // namespace

void ContactStore::open(std::uint32_t slot) const {
    if (slot >= n_grains) return;
    Tile& own = tile_of(slot);
    index_contacts(labels, own);
    for (const IncomingSums& in : own.incoming) index_contacts(labels, tiles[static_cast<std::size_t>(in.from_tile)]);
}

void ContactStore::void_histories(int doubles) {
    history_doubles = doubles;
    for (Tile& t : tiles) t.void_histories(doubles);
    rows.assign(partners.size() * static_cast<std::size_t>(doubles), 0.0);
}

void index_contacts(const std::vector<Label>& labels, Tile& tile) {
    std::vector<std::uint32_t>&first = tile.by_grain.first, &numbers = tile.by_grain.number, &keys = tile.by_grain.key; // the lambdas' own: clang 14 has no capture of bindings
    if (!first.empty()) return;
    const TileLocal n = tile.count + tile.n_border;
    // Counts two places on, so that filling with first[id + 1]++ leaves first[id] right.
    first.assign(std::size_t{n} + 2, 0);
    const auto each_end = [&](auto visit) {
        each_touching(tile, [&](std::uint32_t number, const ContactList& list, std::uint32_t k, Label wall) {
            const CandidatePair pair = list.contacts[k];
            const TileLocal own = pair.own(), partner = pair.partner();
            visit(own, number, partner, wall);
            if (wall < 0 && partner < n) visit(partner, number, own, wall);
        });
    };
    each_end([&](TileLocal id, std::uint32_t, TileLocal, Label) { ++first[id + 2]; });
    for (std::size_t id = 2; id < first.size(); ++id) first[id] += first[id - 1];
    resize_tightly(numbers, first.back());
    resize_tightly(keys, first.back() + std::size_t{7});
    each_end([&](TileLocal id, std::uint32_t number, TileLocal partner, Label wall) {
        const std::uint32_t at = first[id + 1]++;
        numbers[at] = number;
        keys[at] = key_of(wall >= 0 ? wall : labels[tile.index_of[partner]]);
    });
    first.pop_back();
}

void inherit_histories(const ContactStore& store, const std::vector<std::uint32_t>& slot_of, const std::vector<Particle>& particles, NearPairs& near, Tile& tile, InheritScratch& scratch) {
    using Grain = InheritScratch::Grain;
    const TileLocal n_here = tile.count + tile.n_border;
    scratch.grains.resize(tile.index_of.size());
    const Tile* last = nullptr;
    for (TileLocal id = 0; id < tile.index_of.size(); ++id) {
        Grain& g = scratch.grains[id] = {particles[tile.index_of[id]].label, nullptr, 0};
        if (id >= n_here) continue;
        g.id = slot_of[tile.index_of[id]];
        if (g.id >= store.n_grains) continue;
        // Grains that stand together stood together.
        if (last == nullptr || g.id < last->first || g.id >= last->first + last->count) {
            last = &store.tile_of(g.id);
            TALUS_CHECK(!last->by_grain.first.empty());
        }
        g.tile = last;
        g.id -= last->first;
    }
    const auto held_by = [&](const Grain& g, Label partner) {
        if (g.tile != nullptr) return find_in_tile(store.labels, *g.tile, g.id, partner);
        return find_among_all(store, g.id, partner);
    };
    const auto find = [&](CandidatePair pair) -> HistoryPlace {
        const Grain &a = scratch.grains[pair.own()], &b = scratch.grains[pair.partner()];
        const HistoryPlace place = held_by(a, b.label);
        if (place.found() || a.tile == nullptr) return place;
        // A pair across tiles stood in one of the two.
        if (pair.partner() >= n_here) return find_among_all(store, a.tile->first + a.id, b.label);
        return b.tile == a.tile ? place : held_by(b, a.label);
    };
    const auto inherit = [&](ContactList& list, std::vector<CandidatePair>& pairs, auto place_of) {
        auto& matches = scratch.matches;
        matches.clear();
        std::size_t others = 0;
        for (const CandidatePair pair : pairs) {
            if (const HistoryPlace place = place_of(pair); place.found())
                matches.push_back({pair, place});
            else
                pairs[others++] = pair;
        }
        list.set_candidates({pairs.data(), others});
        // Room for those that will touch before the next rebuild, too.
        list.reserve_contacts(matches.size() + matches.size() / 16);
        double row[kMaxHistoryDoubles];
        for (const InheritScratch::Match& m : matches) {
            store.get(m.place, row);
            list.set_touching(list.add_contact(m.pair), row);
        }
    };
    tile.start_lists(near.with_walls.size(), store.history_doubles);
    inherit(tile.pairs, near.of_grains, find);
    for (std::size_t w = 0; w < tile.walls.size(); ++w) inherit(tile.walls[w], near.with_walls[w], [&](CandidatePair p) { return held_by(scratch.grains[p.own()], kWallLabel + static_cast<Label>(w)); });
}

} // namespace talus::core
