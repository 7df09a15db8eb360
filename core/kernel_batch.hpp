// core/kernel_batch.hpp: what the pair and the wall kernel share: finding the touching candidates, rows in and out of lanes, and a
// block of contacts on its way through the stages of a law.
//
// Contacts are taken in blocks, W at a time, stage by stage: each stage runs over all batches of the block before the next begins.
// What passes between stages stays in L1, and the processor has several contacts under way: a contact taken through all stages
// at once is one chain, longer than it can look ahead.
#pragma once

#include <algorithm>
#include <bit>
#include <limits>

#include "core/contact_lanes.hpp"
#include "core/force_kernel.hpp"

namespace talus::core::kernel {

/// Contacts that go through the stages together: eight batches fill the processor and leave room in L1 for the grains.
template <class V>
inline constexpr std::uint32_t kBlock = 8 * kLanes<V>;

/// Contacts between the one whose history is asked of memory and the one that is looked at.
inline constexpr std::uint32_t kAhead = 64;

/// Bits of the first n of W lanes.
constexpr unsigned first_lanes(std::uint32_t n, int W) { return n >= static_cast<std::uint32_t>(W) ? (1u << W) - 1u : (1u << n) - 1u; }

/// Make contacts of the candidates that touch. @param touch8  touch8(first): touching bits of eight candidates
template <class Touch8>
inline void admit_touching(ContactList& list, Touch8 touch8) {
    list.retire_parted();
    // From the end, so that the last candidate, which takes the place of one that leaves, has been looked at.
    for (std::uint32_t first = (list.n_candidates + 7) / 8 * 8; first > 0;) {
        first -= 8;
        unsigned mask = touch8(first) & first_lanes(list.n_candidates - first, 8);
        while (mask != 0) [[unlikely]] {
            const int k = std::bit_width(mask) - 1;
            mask &= ~(1u << k);
            list.add_contact(list.candidates[first + static_cast<std::uint32_t>(k)]);
            list.candidates[first + static_cast<std::uint32_t>(k)] = list.candidates[--list.n_candidates];
        }
    }
}

/// Store which of eight contacts touch. Histories of those that begin to are cleared; ended(contact) is told of each that ends, while
/// its history still stands.
template <int kHistory, class Ended>
inline void note_touching(ContactList& list, std::uint32_t first, unsigned touching, Ended ended) {
    std::uint8_t& stored = list.touching[first / 8];
    if (touching == stored) [[likely]] return;
    if constexpr (kHistory > 0)
        for (unsigned fresh = touching & ~unsigned{stored}; fresh != 0; fresh &= fresh - 1)
            for (int c = 0; c < kHistory; ++c) list.history[static_cast<std::size_t>(first / 8) * kHistory + static_cast<std::size_t>(c)].v[std::countr_zero(fresh)] = 0.0;
    for (unsigned gone = ~touching & stored; gone != 0; gone &= gone - 1) ended(first + static_cast<std::uint32_t>(std::countr_zero(gone)));
    stored = static_cast<std::uint8_t>(touching);
}

template <class V>
inline StepConstants<V> step_constants(const ForceContext& c) {
    const double floor = c.laws.damping == Damping::clipped ? 0.0 : -std::numeric_limits<double>::infinity();
    return {splat<V>(c.dt), splat<V>(floor), splat<V>(c.laws.rolling_rate)};
}

/// Columns of the rows of W grains.
template <class V, class Id>
inline void load_grains(const std::vector<Quad>& quads, const Id& ids, V (&out)[4]) {
    const double* rows[kLanes<V>];
    for (int l = 0; l < kLanes<V>; ++l) rows[l] = quads.data()[ids[l]].v;
    load_columns(rows, out);
}
template <class V>
inline Vec3<V> vector_of(const V (&columns)[4]) { return {columns[0], columns[1], columns[2]}; }

/// Columns of the histories of W contacts, each eight doubles from the next.
template <class V, class Law>
inline void load_history(const double* columns, ContactHistory<V>& h) {
    if constexpr (Law::kHistoryDoubles > 0) {
        const auto column = [&](int c) { return load_lanes<V>(columns + 8 * c); };
        h.tangential = {{column(0), column(1), column(2)}, column(3)};
        if constexpr (Law::kHistoryDoubles > 4) h.rolling = {column(4), column(5), column(6)};
    }
}

/// Lanes that do not touch are stored as well: they are void.
template <class V, class Law>
inline void store_history(const ContactHistory<V>& h, double* columns) {
    if constexpr (Law::kHistoryDoubles > 0) {
        const auto put = [&](int c, V v) { store_lanes(columns + 8 * c, v); };
        put(0, h.tangential.vector.x);
        put(1, h.tangential.vector.y);
        put(2, h.tangential.vector.z);
        put(3, h.tangential.last);
        if constexpr (Law::kHistoryDoubles > 4) {
            put(4, h.rolling.x);
            put(5, h.rolling.y);
            put(6, h.rolling.z);
        }
    }
}

/// Three columns of a force or torque as integer rows (x, y, z, 0); zero where the bit of `lanes` is not set.
template <class V>
inline void integer_rows(const Vec3<V>& v, double scale, unsigned lanes, I4 (&rows)[kLanes<V>]) {
    using Int = typename Lanes<V>::Int;
    const V s = splat<V>(scale);
    const Int columns[4] = {to_integer(v.x, s), to_integer(v.y, s), to_integer(v.z, s), Int{}};
    to_rows(columns, rows);
    if (lanes != first_lanes(kLanes<V>, kLanes<V>)) [[unlikely]]
        for (int l = 0; l < kLanes<V>; ++l) rows[l] = (lanes >> l & 1) != 0 ? rows[l] : I4{};
}

// A force or torque against the cap, which no component may pass. Not-a-number fails every comparison, so tests are for what is right.

/// Square of a force or torque over that of the cap; up to one no component is beyond it.
template <class V>
inline V cap_share(const Vec3<V>& v, double scale) {
    const double share = scale / kCapUnits;
    return dot(v, v) * splat<V>(share * share);
}
/// Bits of the lanes in which a component is beyond the cap.
template <class V>
inline unsigned beyond_cap(const Vec3<V>& v, double scale) {
    const V s = splat<V>(scale), cap = splat<V>(kCapUnits);
    return ~bits_of((magnitude(v.x * s) <= cap) & (magnitude(v.y * s) <= cap) & (magnitude(v.z * s) <= cap));
}
template <class V>
inline bool all_within(V shares) {
    return bits_of(shares <= splat<V>(1.0)) == first_lanes(kLanes<V>, kLanes<V>);
}

template <class V>
inline void add_heat(const Dissipation<V>& d, double scale, unsigned lanes, HeatSum& heat) {
    I4 rows[kLanes<V>];
    integer_rows(Vec3<V>{d.friction, d.damping, d.rolling}, scale, lanes, rows);
    for (int l = 0; l < kLanes<V>; ++l) {
        heat.friction += rows[l][0];
        heat.damping += rows[l][1];
        heat.rolling += rows[l][2];
    }
}

/// What a contact that ends still held in its springs is lost: to friction and rolling.
template <class Law>
inline void add_released(const ForceContext& context, const PairParameters& p, const ContactList& list, std::uint32_t contact, HeatSum& heat) {
    if constexpr (Law::kHistoryDoubles > 0) {
        double row[kMaxHistoryDoubles];
        list.get_history(contact, row);
        heat.friction += to_integer(Law::released_energy(splat_parameters<double>(p), row), context.units.torque.scale);
    }
}

inline void note_breach(CapBreach& breach, Label i, Label j, double force) {
    // The pair with the smallest labels is named, whatever the order of evaluation.
    if (breach.found && (breach.i < i || (breach.i == i && breach.j <= j))) return;
    breach = {true, i, j, force};
}

template <class V>
inline double lane(V v, int l) {
    if constexpr (kLanes<V> == 1)
        return v;
    else
        return v[l];
}

inline int material_of(const Quad& spin) { return static_cast<int>(__builtin_bit_cast(std::uint64_t, spin.v[3]) & 0xff); }

/// W contacts under evaluation.
template <class V>
struct Batch : ContactState<V> {
    std::uint32_t first;             // of the list's contacts
    unsigned lanes;                  // bits of those that touch
    TileLocal i[kLanes<V>], j[kLanes<V>];
    V radius_i, radius_j, mass_i, mass_j;
    ContactParameters<V> parameters; // where materials differ
};

/// Batches of a block in which any contact touches, and the histories of the list. begin(batch) sets first, i, j (of a pair) and the first part of
/// the geometry, and returns the touching bits; the end of the batches that go on.
template <class V, int kHistory, class Begin, class Ended>
inline Batch<V>* begin_batches(ContactList& list, std::uint32_t block, Batch<V>* batches, Begin begin, Ended ended) {
    constexpr int W = kLanes<V>;
    Batch<V>* next = batches;
    const std::uint32_t end = std::min(block + kBlock<V>, list.n_contacts);
    for (std::uint32_t octet = block; octet < end; octet += 8) {
        // Needed some blocks on; the hardware starts anew at every block.
        if constexpr (kHistory > 0) {
            const Octet* ahead = list.history.data() + static_cast<std::size_t>(octet + kAhead) / 8 * kHistory;
            for (int c = 0; c < kHistory; ++c) __builtin_prefetch(ahead + c, 1);
        }
        unsigned touching = 0;
        for (std::uint32_t first = octet; first < std::min(octet + 8, end); first += W) {
            next->first = first;
            next->lanes = begin(*next) & first_lanes(end - first, W);
            touching |= next->lanes << (first - octet);
            next += next->lanes != 0 ? 1 : 0;
        }
        note_touching<kHistory>(list, octet, touching, ended);
    }
    return next;
}

/// The batches through the stages of a law, and their histories in and out. @param parameters  of a batch
template <class V, class Law, bool kLedger, class Parameters>
inline void run_law(Batch<V>* batches, Batch<V>* end, ContactList& list, const StepConstants<V>& constants, bool advance, Parameters parameters) {
    const auto columns = [data = reinterpret_cast<double*>(list.history.data())](std::uint32_t contact) { return data + static_cast<std::size_t>(contact / 8) * (8 * Law::kHistoryDoubles) + contact % 8; };
    for (Batch<V>* x = batches; x != end; ++x) load_history<V, Law>(columns(x->first), x->history);
    Law::template stages<V, kLedger>(constants, [&](auto stage) {
        for (Batch<V>* x = batches; x != end; ++x) stage(*x, parameters(*x));
    });
    if (advance)
        for (Batch<V>* x = batches; x != end; ++x) store_history<V, Law>(x->history, columns(x->first));
}

} // namespace talus::core::kernel
