// Contact histories laid out grain by grain and found again by label: nothing is lost and nothing is invented.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <set>

#include "../support/lists.hpp"
#include "core/contact_history.hpp"

namespace talus::core {
namespace {

using namespace test;

constexpr int kDoubles = kMaxHistoryDoubles;
using Row = std::array<double, kDoubles>;
using Histories = std::map<std::pair<Label, Label>, Row>; // (smaller label, larger label or wall)

std::vector<WallPlane> walls_of(const System& s) {
    return {{{0.0, s.domain.lo[1], 0.0}, {0.0, 1.0, 0.0}, {0, 0, 0}, 0}, {{s.domain.hi[0], 0.0, 0.0}, {-1.0, 0.0, 0.0}, {0, 0, 0}, 0}};
}

System system_of(int n, std::uint64_t seed) {
    const double lengths[3] = {5.1 * kReach, 3.3 * kReach, 4.2 * kReach};
    return random_system(lengths, {false, false, true}, n, seed);
}

/// Let about half of the candidates touch, with random rows, and let some of those part again.
void touch_some(Lists& lists, std::uint64_t seed) {
    Random random(seed);
    const auto fill = [&](ContactList& list) {
        const std::vector<CandidatePair> all(list.candidates.begin(), list.candidates.begin() + list.n_candidates);
        list.start(list.history_doubles);
        for (const CandidatePair pair : all) {
            const double lot = random.uniform(0.0, 1.0);
            if (lot < 0.4) {
                list.add_candidate(pair);
                continue;
            }
            Row row;
            for (double& v : row) v = random.uniform(-1.0, 1.0);
            const std::uint32_t k = list.add_contact(pair);
            list.set_touching(k, row.data());
            if (lot < 0.5) list.touching[k / 8] = static_cast<std::uint8_t>(list.touching[k / 8] & ~(1u << k % 8)); // its row is void
        }
    };
    for (Tile& t : lists.tiles) {
        fill(t.pairs);
        for (auto& w : t.walls) fill(w);
    }
}

Histories histories_of(const Lists& lists) {
    Histories h;
    const auto take = [&](const ContactList& list, const Tile& t, Label wall) {
        for (std::uint32_t k = 0; k < list.n_contacts; ++k) {
            if (!list.touches(k)) continue;
            const Label a = lists.particles[t.index_of[list.contacts[k].own()]].label;
            const Label b = wall >= 0 ? wall : lists.particles[t.index_of[list.contacts[k].partner()]].label;
            Row row;
            list.get_history(k, row.data());
            EXPECT_TRUE(h.insert({{std::min(a, b), std::max(a, b)}, row}).second);
        }
    };
    for (const Tile& t : lists.tiles) {
        take(t.pairs, t, -1);
        for (std::size_t w = 0; w < t.walls.size(); ++w) take(t.walls[w], t, kWallLabel + static_cast<Label>(w));
    }
    return h;
}

/// The lists must outlive it.
ContactStore lay_out(Lists& lists) {
    ContactStore store;
    store.history_doubles = kDoubles;
    store.tiles = lists.tiles;
    store.n_grains = static_cast<LocalIndex>(lists.particles.size());
    for (const Particle& p : lists.particles) store.labels.push_back(p.label);
    for (Tile& t : lists.tiles) index_contacts(store.labels, t);
    return store;
}

void inherit(const ContactStore& store, const std::vector<std::uint32_t>& slots, Lists& now) {
    InheritScratch scratch;
    for (std::size_t t = 0; t < now.tiles.size(); ++t) {
        const auto before = now.listed();
        NearPairs near = now.near[t];
        inherit_histories(store, slots, now.particles, near, now.tiles[t], scratch);
        EXPECT_EQ(now.listed(), before);
    }
}

std::vector<std::uint32_t> slots_of(const Lists& old, const Lists& now) {
    std::map<Label, std::uint32_t> slot;
    for (std::uint32_t i = 0; i < old.particles.size(); ++i) slot[old.particles[i].label] = i;
    std::vector<std::uint32_t> slots;
    for (const Particle& p : now.particles) slots.push_back(slot.at(p.label));
    return slots;
}

TEST(ContactHistory, survives_new_tiles_and_a_new_order_row_by_row) {
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
        const System s = system_of(300, seed);
        Lists old(s, 20, walls_of(s), kDoubles);
        touch_some(old, seed + 100);
        const Histories before = histories_of(old);
        ASSERT_GT(before.size(), 300u);
        const ContactStore store = lay_out(old);
        for (const std::size_t tile_grains : {7u, 60u, 100000u}) {
            Lists now(s, tile_grains, walls_of(s), kDoubles);
            inherit(store, slots_of(old, now), now);
            EXPECT_EQ(histories_of(now), before);
        }
    }
}

TEST(ContactHistory, is_known_to_both_grains_of_a_pair_wherever_the_pair_is_listed) {
    const System s = system_of(300, 77);
    Lists lists(s, 20, walls_of(s), kDoubles);
    touch_some(lists, 5);
    const Histories h = histories_of(lists);
    std::size_t at_walls = 0, across = 0, seen = 0;
    for (const auto& [who, row] : h) at_walls += who.second >= kWallLabel ? 1 : 0;
    EXPECT_GT(at_walls, 5u);
    for (const Tile& t : lists.tiles)
        for (std::uint32_t k = 0; k < t.pairs.n_contacts; ++k) across += t.pairs.touches(k) && t.pairs.contacts[k].partner() >= t.count ? 1 : 0;
    EXPECT_GT(across, 50u);
    const ContactStore store = lay_out(lists);
    for (std::uint32_t g = 0; g < lists.particles.size(); ++g) {
        std::set<Label> partners;
        store.each(g, [&](Label partner, const HistoryPlace& place) {
            ++seen;
            const Label me = lists.particles[g].label;
            EXPECT_TRUE(partners.insert(partner).second) << "no partner twice";
            const auto found = h.find({std::min(me, partner), std::max(me, partner)});
            ASSERT_NE(found, h.end());
            Row row;
            store.get(place, row.data());
            EXPECT_EQ(row, found->second);
        });
    }
    EXPECT_EQ(seen, 2 * (h.size() - at_walls) + at_walls);
}

TEST(ContactHistory, is_found_where_only_the_tiles_that_a_grain_asks_for_are_indexed) {
    const System s = system_of(300, 21);
    Lists whole(s, 20, walls_of(s), kDoubles), lists(s, 20, walls_of(s), kDoubles);
    touch_some(whole, 3);
    touch_some(lists, 3);
    const ContactStore all = lay_out(whole);
    ContactStore store = all;
    store.tiles = lists.tiles;
    for (std::uint32_t g = 0; g < lists.particles.size(); ++g) {
        for (Tile& t : lists.tiles) t.by_grain.first.clear();
        store.open(g);
        const auto contacts_in = [&](const ContactStore& from) {
            std::map<Label, Row> contacts;
            from.each(g, [&](Label partner, const HistoryPlace& place) { from.get(place, contacts[partner].data()); });
            return contacts;
        };
        EXPECT_EQ(contacts_in(store), contacts_in(all));
    }
}

TEST(ContactHistory, of_another_law_starts_anew_and_contacts_stay) {
    const System s = system_of(200, 4);
    Lists old(s, 20, walls_of(s), kDoubles);
    touch_some(old, 2);
    const Histories before = histories_of(old);
    ContactStore store = lay_out(old);
    const double row[kDoubles] = {1, 2, 3, 4, 5, 6, 7};
    const Label partner = 7;
    const std::uint32_t came = store.append(&partner, row, 1);
    store.void_histories(4);
    store.each(came, [&](Label label, const HistoryPlace& place) {
        double now[4] = {9, 9, 9, 9};
        store.get(place, now);
        EXPECT_EQ(label, partner);
        for (const double v : now) EXPECT_EQ(v, 0.0);
    });
    Lists now(s, 33, walls_of(s), 4);
    inherit(store, slots_of(old, now), now);
    std::size_t n = 0;
    for (const Tile& t : now.tiles) {
        n += t.pairs.n_touching();
        for (const ContactList& w : t.walls) n += w.n_touching();
        for (const Octet& column : t.pairs.history)
            for (const double v : column.v) EXPECT_EQ(v, 0.0);
    }
    EXPECT_EQ(n, before.size());
}

TEST(ContactHistory, of_a_pair_that_is_listed_no_more_ends_and_a_new_pair_has_none) {
    System s = system_of(200, 9);
    Lists old(s, 20, walls_of(s), kDoubles);
    touch_some(old, 7);
    const Histories before = histories_of(old);
    const ContactStore store = lay_out(old);
    // Every third grain jumps elsewhere.
    Random random(4);
    std::set<Label> moved;
    for (std::size_t k = 0; k < s.particles.size(); k += 3) {
        for (int a = 0; a < 3; ++a) s.particles[k].position[a] = random.uniform(s.domain.lo[a], s.domain.hi[a]);
        moved.insert(s.particles[k].label);
    }
    Lists now(s, 20, walls_of(s), kDoubles);
    inherit(store, slots_of(old, now), now);
    const Histories after = histories_of(now);
    EXPECT_LT(after.size(), before.size());
    std::size_t between_others = 0;
    for (const auto& [who, row] : after) {
        const auto found = before.find(who);
        ASSERT_NE(found, before.end()) << "invented";
        EXPECT_EQ(found->second, row);
    }
    for (const auto& [who, row] : before) {
        if (moved.contains(who.first) || moved.contains(who.second)) continue;
        ++between_others;
        EXPECT_TRUE(after.contains(who)) << "lost";
    }
    EXPECT_GT(between_others, 50u);
}

TEST(ContactHistory, of_grains_that_arrive_is_appended_and_found) {
    const System s = system_of(120, 10);
    Lists whole(s, 20, walls_of(s), kDoubles);
    touch_some(whole, 8);
    const Histories before = histories_of(whole);
    const ContactStore all = lay_out(whole);
    const auto n = static_cast<std::uint32_t>(whole.particles.size());
    const auto contacts_of = [&](std::uint32_t g, std::vector<Label>& partners, std::vector<double>& rows) {
        all.each(g, [&](Label partner, const HistoryPlace& place) {
            partners.push_back(partner);
            rows.resize(rows.size() + kDoubles);
            all.get(place, rows.data() + rows.size() - kDoubles);
        });
    };
    // Every grain arrives in turn, the last one first, with its own copies of rows; or every third does, and the others were here.
    for (const std::uint32_t step : {1u, 3u}) {
        ContactStore store;
        if (step > 1) store = all;
        store.history_doubles = kDoubles;
        std::vector<std::uint32_t> slots(n);
        for (std::uint32_t g = 0; g < n; ++g) slots[g] = g;
        for (std::uint32_t g = n; g-- > 0;) {
            if (g % step != 0) continue;
            std::vector<Label> partners;
            std::vector<double> rows;
            contacts_of(g, partners, rows);
            slots[g] = store.append(partners.data(), rows.data(), static_cast<std::uint32_t>(partners.size()));
        }
        Lists now(s, 20, walls_of(s), kDoubles);
        inherit(store, slots, now);
        EXPECT_EQ(histories_of(now), before);
    }
}

} // namespace
} // namespace talus::core
