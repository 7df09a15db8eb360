// Contacts and candidates of a list: rows keep their values when others leave, and nothing is lost.
#include <gtest/gtest.h>

#include <set>

#include "../support/bed.hpp"
#include "core/contact_list.hpp"

namespace talus::core {
namespace {

constexpr int kDoubles = kMaxHistoryDoubles;

double value(CandidatePair p, int c) { return 1000.0 * p.i + p.j + 0.125 * c; }

/// So many contacts; those for which `parted` holds touch no more.
template <class Parted>
ContactList list_of(std::uint32_t n, Parted parted) {
    ContactList list;
    list.start(kDoubles);
    for (std::uint32_t k = 0; k < n; ++k) {
        const CandidatePair pair{k, k + 1 + k % 3};
        double row[kDoubles];
        for (int c = 0; c < kDoubles; ++c) row[c] = value(pair, c);
        const std::uint32_t contact = list.add_contact(pair);
        list.set_touching(contact, row);
        if (parted(k)) list.touching[contact / 8] = static_cast<std::uint8_t>(list.touching[contact / 8] & ~(1u << contact % 8));
    }
    return list;
}

std::multiset<std::pair<TileLocal, TileLocal>> pairs_of(const ContactList& list) {
    std::multiset<std::pair<TileLocal, TileLocal>> all;
    list.each_pair([&](CandidatePair p) { all.insert({p.i, p.j}); });
    return all;
}

TEST(ContactList, contacts_that_part_stay_until_they_are_a_quarter_and_then_become_candidates) {
    for (std::uint32_t n = 1; n < 70; ++n)
        for (std::uint32_t parted = 0; parted <= n; ++parted) {
            SCOPED_TRACE(std::to_string(parted) + " of " + std::to_string(n));
            // Spread over the list.
            ContactList list = list_of(n, [&](std::uint32_t k) { return (k + 1) * parted / n > k * parted / n; });
            const auto before = pairs_of(list);
            list.retire_parted();
            const bool retired = 4 * parted > n;
            EXPECT_EQ(list.n_contacts, retired ? n - parted : n);
            EXPECT_EQ(list.n_candidates, retired ? parted : 0u);
            EXPECT_EQ(pairs_of(list), before);
            EXPECT_EQ(list.contacts.size(), (list.n_contacts + 7) / 8 * 8) << "whole octets";
            EXPECT_EQ(list.touching.size(), list.contacts.size() / 8);
            EXPECT_EQ(list.history.size(), list.touching.size() * kDoubles);
            std::uint32_t open = 0;
            for (std::uint32_t k = 0; k < list.n_contacts; ++k) {
                if (!list.touches(k)) continue;
                ++open;
                double row[kDoubles];
                list.get_history(k, row);
                for (int c = 0; c < kDoubles; ++c) EXPECT_EQ(row[c], value(list.contacts[k], c));
            }
            EXPECT_EQ(open, n - parted);
            if (HasFailure()) return;
        }
}

TEST(ContactList, candidates_are_padded_to_whole_octets_with_pairs_that_exist) {
    for (std::uint32_t n = 0; n < 20; ++n) {
        std::vector<CandidatePair> pairs;
        ContactList one, other;
        one.start(0);
        other.start(0);
        for (std::uint32_t k = 0; k < n; ++k) {
            pairs.push_back({k, k + 1});
            one.add_candidate(pairs.back());
        }
        other.set_candidates(pairs);
        for (const ContactList& list : {one, other}) {
            EXPECT_EQ(list.n_candidates, n);
            ASSERT_EQ(list.candidates.size(), (n + 7) / 8 * 8);
            for (std::size_t k = n; k < list.candidates.size(); ++k) EXPECT_EQ(list.candidates[k].i + list.candidates[k].j, 0u);
        }
    }
}

} // namespace
} // namespace talus::core
