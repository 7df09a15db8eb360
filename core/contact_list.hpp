// core/contact_list.hpp: the contacts of a tile, among its grains or with one wall, their histories, and the candidates for more.
//
// A candidate that touches becomes a contact, and stays one when it parts until many have. So a kernel takes contacts where they
// stand, several in lanes, and searches only the other candidates. Order shows in no bit.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/particles.hpp"
#include "core/types.hpp"

namespace talus::core {

/// A pair as two tile-local ids; i has the smaller label. Own grains of a tile have smaller ids than border grains, so that one of
/// the two is always the tile's.
struct CandidatePair {
    TileLocal i, j;

    TileLocal own() const { return std::min(i, j); }
    TileLocal partner() const { return std::max(i, j); }
};

/// One component of the histories of eight contacts in a row, so that kernels of any width load and store whole lanes.
struct alignas(64) Octet {
    double v[8];
};

/// Room for n items: memory that a vector has is used again, since the system gives pages slowly, but not kept when it is empty and
/// far too large.
template <class T>
void make_room(std::vector<T>& v, std::size_t n) {
    if (v.empty() && v.capacity() > n + n / 4 + 64) v = std::vector<T>();
    v.reserve(n);
}

/// n items, those that were there as they are; without the room to spare that resize would make.
template <class T>
void resize_tightly(std::vector<T>& v, std::size_t n) {
    v.reserve(n);
    v.resize(n);
}

struct ContactList {
    std::vector<CandidatePair> contacts;   // touch, or did not long ago; padded to whole octets
    std::vector<std::uint8_t> touching;    // one bit a contact: touched at the last evaluation; histories of others are void
    std::vector<Octet> history;            // history_doubles columns an octet of contacts
    std::vector<CandidatePair> candidates; // the other pairs near enough to touch; padded to whole octets
    std::uint32_t n_contacts = 0, n_candidates = 0;
    int history_doubles = 0;

    /// Empty, for histories of so many doubles; memory is kept.
    void start(int doubles) {
        n_contacts = n_candidates = 0;
        history_doubles = doubles;
        contacts.clear();
        touching.clear();
        history.clear();
        candidates.clear();
    }
    void set_candidates(std::span<const CandidatePair> pairs) {
        n_candidates = static_cast<std::uint32_t>(pairs.size());
        candidates.clear();
        make_room(candidates, whole_octets(n_candidates));
        candidates.assign(pairs.begin(), pairs.end());
        candidates.resize(whole_octets(n_candidates), CandidatePair{0, 0});
    }
    void add_candidate(CandidatePair pair) {
        if (n_candidates % 8 == 0) candidates.resize(n_candidates + 8, CandidatePair{0, 0});
        candidates[n_candidates++] = pair;
    }
    /// Room for so many contacts.
    void reserve_contacts(std::size_t n) {
        n = whole_octets(n);
        make_room(contacts, n);
        make_room(touching, n / 8);
        make_room(history, n / 8 * static_cast<std::size_t>(history_doubles));
    }
    /// @return its number; not touching, its history void
    std::uint32_t add_contact(CandidatePair pair) {
        if (n_contacts % 8 == 0) {
            if (contacts.capacity() == n_contacts) reserve_contacts(n_contacts + n_contacts / 8 + 8);
            contacts.resize(n_contacts + 8, CandidatePair{0, 0});
            touching.push_back(0);
            history.resize(touching.size() * static_cast<std::size_t>(history_doubles));
        }
        contacts[n_contacts] = pair;
        return n_contacts++;
    }

    /// visit(pair) for contacts and candidates.
    template <class Visit>
    void each_pair(Visit visit) const {
        for (std::uint32_t k = 0; k < n_contacts; ++k) visit(contacts[k]);
        for (std::uint32_t k = 0; k < n_candidates; ++k) visit(candidates[k]);
    }

    bool touches(std::uint32_t contact) const { return (touching[contact / 8] >> (contact % 8) & 1) != 0; }
    /// @param row  history_doubles values
    void set_touching(std::uint32_t contact, const double* row) {
        touching[contact / 8] = static_cast<std::uint8_t>(touching[contact / 8] | 1u << (contact % 8));
        for (int c = 0; c < history_doubles; ++c) history[column(contact, c)].v[contact % 8] = row[c];
    }
    void get_history(std::uint32_t contact, double* row) const {
        for (int c = 0; c < history_doubles; ++c) row[c] = history[column(contact, c)].v[contact % 8];
    }
    std::uint32_t n_touching() const {
        std::uint32_t n = 0;
        for (const std::uint8_t bits : touching) n += static_cast<std::uint32_t>(std::popcount(bits));
        return n;
    }
    /// Once a quarter of the contacts has parted, make candidates of those again.
    void retire_parted() {
        if (4 * (n_contacts - n_touching()) <= n_contacts) return;
        std::uint32_t kept = 0;
        for (std::uint32_t k = 0; k < n_contacts; ++k) {
            if (!touches(k)) {
                add_candidate(contacts[k]);
                continue;
            }
            contacts[kept] = contacts[k];
            for (int c = 0; c < history_doubles; ++c) history[column(kept, c)].v[kept % 8] = history[column(k, c)].v[k % 8];
            ++kept;
        }
        n_contacts = kept;
        contacts.resize(kept);
        contacts.resize(whole_octets(kept), CandidatePair{0, 0});
        touching.assign(contacts.size() / 8, 0xff);
        if (kept % 8 != 0) touching.back() = static_cast<std::uint8_t>((1u << kept % 8) - 1u);
        history.resize(touching.size() * static_cast<std::size_t>(history_doubles));
    }
    /// Every contact starts anew, with histories of so many doubles, touching as before.
    void void_histories(int doubles) {
        history_doubles = doubles;
        history.assign(touching.size() * static_cast<std::size_t>(doubles), Octet{});
    }
    std::size_t bytes() const {
        return (contacts.capacity() + candidates.capacity()) * sizeof(CandidatePair) + touching.capacity() + history.capacity() * sizeof(Octet);
    }

private:
    static std::size_t whole_octets(std::size_t n) { return (n + 7) / 8 * 8; }
    std::size_t column(std::uint32_t contact, int c) const { return static_cast<std::size_t>(contact / 8) * static_cast<std::size_t>(history_doubles) + static_cast<std::size_t>(c); }
};

/// Longest history of a law, for rows on the stack.
inline constexpr int kMaxHistoryDoubles = 7;

} // namespace talus::core
