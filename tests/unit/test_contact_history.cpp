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

constexpr int kQuads = 2;
using Row = std::array<double, 4 * kQuads>;
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

ContactStore lay_out(const Lists& lists, bool backwards = false) {
    ContactStore store;
    ContactLayout layout(store, lists.particles, static_cast<LocalIndex>(lists.particles.size()), kQuads);
    const int n = static_cast<int>(lists.tiles.size());
    for (int t = 0; t < n; ++t) layout.count(lists.tiles[static_cast<std::size_t>(backwards ? n - 1 - t : t)]);
    layout.allocate(lists.tiles);
    for (int t = 0; t < n; ++t) layout.fill(backwards ? n - 1 - t : t, lists.tiles[static_cast<std::size_t>(backwards ? n - 1 - t : t)]);
    layout.finish();
    return store;
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
        Lists old(s, 20, walls_of(s), 4 * kQuads);
        touch_some(old, seed + 100);
        const Histories before = histories_of(old);
        ASSERT_GT(before.size(), 300u);
        const ContactStore store = lay_out(old);
        for (const std::size_t tile_grains : {7u, 60u, 100000u}) {
            Lists now(s, tile_grains, walls_of(s), 4 * kQuads);
            const auto slots = slots_of(old, now);
            for (Tile& t : now.tiles) inherit_histories(store, slots, now.particles, t);
            EXPECT_EQ(histories_of(now), before);
        }
    }
}

TEST(ContactHistory, has_an_entry_at_both_grains_of_a_pair_and_one_at_a_wall) {
    const System s = system_of(300, 77);
    Lists lists(s, 20, walls_of(s), 4 * kQuads);
    touch_some(lists, 5);
    const Histories h = histories_of(lists);
    const ContactStore store = lay_out(lists);
    std::size_t at_walls = 0;
    for (const auto& [who, row] : h) at_walls += who.second >= kWallLabel ? 1 : 0;
    EXPECT_GT(at_walls, 5u);
    EXPECT_EQ(store.entries.size(), 2 * (h.size() - at_walls) + at_walls);
    EXPECT_EQ(store.rows.size(), h.size() * kQuads) << "a row is shared by the two grains of a pair";
    EXPECT_EQ(store.first.size(), lists.particles.size() + 1);
    for (std::uint32_t g = 0; g < lists.particles.size(); ++g) {
        std::set<Label> partners;
        for (std::uint32_t e = store.first[g]; e < store.first[g + 1]; ++e) {
            const Label me = lists.particles[g].label, partner = store.entries[e].partner;
            EXPECT_TRUE(partners.insert(partner).second) << "no partner twice";
            const auto found = h.find({std::min(me, partner), std::max(me, partner)});
            ASSERT_NE(found, h.end());
            EXPECT_EQ(std::memcmp(store.row(store.entries[e]), found->second.data(), sizeof(Row)), 0);
            EXPECT_EQ(store.find(g, partner), &store.entries[e]);
        }
        EXPECT_EQ(store.find(g, 123456789), nullptr);
    }
}

TEST(ContactHistory, does_not_depend_on_the_order_in_which_tiles_are_laid_out) {
    const System s = system_of(300, 8);
    Lists old(s, 20, walls_of(s), 4 * kQuads);
    touch_some(old, 6);
    const Histories before = histories_of(old);
    const ContactStore store = lay_out(old, true);
    Lists now(s, 33, walls_of(s), 4 * kQuads);
    for (Tile& t : now.tiles) inherit_histories(store, slots_of(old, now), now.particles, t);
    EXPECT_EQ(histories_of(now), before);
}

TEST(ContactHistory, of_a_pair_that_is_listed_no_more_ends_and_a_new_pair_has_none) {
    System s = system_of(200, 9);
    Lists old(s, 20, walls_of(s), 4 * kQuads);
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
    Lists now(s, 20, walls_of(s), 4 * kQuads);
    for (Tile& t : now.tiles) inherit_histories(store, slots_of(old, now), now.particles, t);
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
    Lists whole(s, 20, walls_of(s), 4 * kQuads);
    touch_some(whole, 8);
    const Histories before = histories_of(whole);
    const ContactStore all = lay_out(whole);
    // A store into which every grain arrives in turn, the last one first, with its own copies of rows.
    ContactStore store;
    store.history_quads = kQuads;
    store.first.push_back(0);
    const auto n = static_cast<std::uint32_t>(whole.particles.size());
    std::vector<std::uint32_t> slots(n);
    for (std::uint32_t g = n; g-- > 0;) {
        std::vector<Label> partners;
        std::vector<Quad> rows;
        for (std::uint32_t e = all.first[g]; e < all.first[g + 1]; ++e) {
            partners.push_back(all.entries[e].partner);
            rows.insert(rows.end(), all.row(all.entries[e]), all.row(all.entries[e]) + kQuads);
        }
        slots[g] = static_cast<std::uint32_t>(store.first.size() - 1);
        store.append(partners.data(), rows.data(), static_cast<std::uint32_t>(partners.size()));
    }
    Lists now(s, 20, walls_of(s), 4 * kQuads);
    for (Tile& t : now.tiles) inherit_histories(store, slots, now.particles, t);
    EXPECT_EQ(histories_of(now), before);
}

} // namespace
} // namespace talus::core
