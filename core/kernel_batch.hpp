// core/kernel_batch.hpp: what the pair and the wall kernel share: finding the touching candidates, rows in and out of lanes, and a
// block of contacts on its way through the stages of a law.
//
// Candidates are filtered in blocks; the touching ones of a block are evaluated W at a time, stage by stage: each stage runs over
// all batches of the block before the next begins. What passes between stages stays in L1, and the processor has several
// contacts under way: a contact taken through all stages at once is one chain, longer than it can look ahead.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

#include "core/contact_lanes.hpp"
#include "core/force_kernel.hpp"

namespace talus::core::kernel {

/// Positions of the set bits of every byte, for compaction.
inline constexpr auto kBitPositions = [] {
    std::array<std::array<std::uint8_t, 8>, 256> t{};
    for (int m = 0; m < 256; ++m)
        for (int b = 0, n = 0; b < 8; ++b)
            if (m >> b & 1) t[m][n++] = static_cast<std::uint8_t>(b);
    return t;
}();

/// Append first + (positions of the bits of `mask`) to out; writes 8 entries, returns how many count.
inline int append_bits(unsigned mask, std::uint32_t first, std::uint32_t* out) {
    const auto& positions = kBitPositions[mask];
    for (int k = 0; k < 8; ++k) out[k] = first + positions[k];
    return std::popcount(mask);
}

/// Candidates that are filtered together.
inline constexpr std::uint32_t kBlock = 64;

/// Find the touching entries of a list and hand them on. `touch8(first)` gives the touching bits of eight entries; `ended(entry)`
/// is told of each contact that ends, while its row still stands; `evaluate(entries, count)` gets up to kBlock + W entries, the last
/// one repeated until `count` is a multiple of W; only the last call of a list has a count that is not.
/// @return number of touching entries
template <int W, int kHistory, class Touch8, class Ended, class Evaluate>
inline std::uint32_t for_contacts(const ContactList& list, Touch8 touch8, Ended ended, Evaluate evaluate) {
    std::uint32_t found[kBlock + 2 * 8];
    std::uint32_t n = 0, total = 0;
    for (std::uint32_t block = 0; block < list.count; block += kBlock) {
        const std::uint32_t end = std::min(block + kBlock, list.count);
        for (std::uint32_t first = block; first < end; first += 8) {
            const std::uint32_t left = list.count - first;
            unsigned mask = touch8(first);
            if (left < 8) mask &= (1u << left) - 1u;
            std::uint8_t& stored = list.touching[first / 8];
            if constexpr (kHistory > 0) {
                // A contact begins: its row is void until now.
                for (unsigned fresh = mask & ~stored & 0xffu; fresh != 0; fresh &= fresh - 1) {
                    double* row = list.history + static_cast<std::size_t>(first + std::countr_zero(fresh)) * kHistory;
                    for (int c = 0; c < kHistory; ++c) row[c] = 0.0;
                }
            }
            for (unsigned gone = ~mask & stored & 0xffu; gone != 0; gone &= gone - 1) ended(first + static_cast<std::uint32_t>(std::countr_zero(gone)));
            stored = static_cast<std::uint8_t>(mask);
            n += append_bits(mask, first, found + n);
        }
        const bool last = end == list.count;
        // A batch that is not full waits for the next block; the last one is filled by repetition.
        const std::uint32_t whole = n / W * W, done = last ? n : whole;
        if (last && n > 0)
            for (std::uint32_t k = n; k % W != 0; ++k) found[k] = found[n - 1];
        if (done > 0) evaluate(found, done);
        total += done;
        for (std::uint32_t k = done; k < n; ++k) found[k - done] = found[k];
        n -= done;
    }
    return total;
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

template <class V, class Law>
inline void load_history(const double* history, const std::uint32_t* entry, ContactHistory<V>& h) {
    if constexpr (Law::kHistoryDoubles > 0) {
        const double* rows[kLanes<V>];
        V q[4];
        for (int l = 0; l < kLanes<V>; ++l) rows[l] = history + static_cast<std::size_t>(entry[l]) * Law::kHistoryDoubles;
        load_columns(rows, q);
        h.tangential = {vector_of(q), q[3]};
        if constexpr (Law::kHistoryDoubles > 4) {
            for (int l = 0; l < kLanes<V>; ++l) rows[l] += 4;
            load_columns(rows, q);
            h.rolling = vector_of(q);
        }
    }
}

/// A repeated entry is stored again: its lanes were computed alike.
template <class V, class Law>
inline void store_history(const ContactHistory<V>& h, double* history, const std::uint32_t* entry) {
    if constexpr (Law::kHistoryDoubles > 0) {
        const auto put = [&](const V(&columns)[4], int offset) {
            V4 rows[kLanes<V>];
            to_rows(columns, rows);
            for (int l = 0; l < kLanes<V>; ++l) store_row(history + static_cast<std::size_t>(entry[l]) * Law::kHistoryDoubles + offset, rows[l]);
        };
        put({h.tangential.vector.x, h.tangential.vector.y, h.tangential.vector.z, h.tangential.last}, 0);
        if constexpr (Law::kHistoryDoubles > 4) put({h.rolling.x, h.rolling.y, h.rolling.z, splat<V>(0.0)}, 4);
    }
}

/// Three columns of a force or torque as integer rows (x, y, z, 0); zero from lane `lanes` on.
template <class V>
inline void integer_rows(const Vec3<V>& v, double scale, int lanes, I4 (&rows)[kLanes<V>]) {
    using Int = typename Lanes<V>::Int;
    const V s = splat<V>(scale);
    const Int columns[4] = {to_integer(v.x * s), to_integer(v.y * s), to_integer(v.z * s), Int{}};
    to_rows(columns, rows);
    if (lanes < kLanes<V>) [[unlikely]]
        for (int l = 0; l < kLanes<V>; ++l) rows[l] = l < lanes ? rows[l] : I4{};
}

/// A force or torque against the cap, which no component may pass. Not-a-number fails every comparison, so tests are for what is right.
template <class V>
struct CapCheck {
    V sum = splat<V>(0.0);               // of all magnitudes: within the cap, so is each
    Mask<V> fine = splat<V>(0.0) <= sum; // each within the cap by itself

    void add(const Vec3<V>& v, double scale) {
        const V s = splat<V>(scale), cap = splat<V>(kCapUnits);
        const V x = magnitude(v.x * s), y = magnitude(v.y * s), z = magnitude(v.z * s);
        sum = sum + x + y + z;
        fine = fine & (x <= cap) & (y <= cap) & (z <= cap);
    }
    /// Bits of those of the first `lanes` lanes in which a component is beyond the cap. The common case is settled by the sum.
    unsigned breaches(int lanes) const {
        const unsigned all = (1u << kLanes<V>) - 1u;
        if (bits_of(sum <= splat<V>(kCapUnits)) == all) [[likely]] return 0;
        return ~bits_of(fine) & ((1u << lanes) - 1u);
    }
};

template <class V>
inline void add_heat(const Dissipation<V>& d, double scale, unsigned lanes, HeatSum& heat) {
    I4 rows[kLanes<V>];
    integer_rows(Vec3<V>{d.friction, d.damping, d.rolling}, scale, kLanes<V>, rows);
    for (int l = 0; l < kLanes<V>; ++l) {
        if ((lanes >> l & 1) == 0) continue;
        heat.friction += rows[l][0];
        heat.damping += rows[l][1];
        heat.rolling += rows[l][2];
    }
}

/// What a contact that ends still held in its springs is lost: to friction and rolling.
template <class Law>
inline void add_released(const ForceContext& context, const PairParameters& p, const ContactList& list, std::uint32_t entry, HeatSum& heat) {
    if constexpr (Law::kHistoryDoubles > 0) {
        const double scale = context.units.torque.scale;
        heat.friction += to_integer(Law::released_energy(splat_parameters<double>(p), list.history + static_cast<std::size_t>(entry) * Law::kHistoryDoubles) * scale);
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
    TileLocal i[kLanes<V>], j[kLanes<V>];
    V radius_i, radius_j, mass_i, mass_j;
    ContactParameters<V> own_parameters; // where materials differ
};

/// All batches of a block through the stages of a law, and their histories in and out.
template <class V, class Law, bool kLedger, class Parameters>
inline void run_law(Batch<V>* batches, int n, const std::uint32_t* found, const ContactList& list, const StepConstants<V>& constants, bool advance, Parameters parameters) {
    constexpr int W = kLanes<V>;
    for (int b = 0; b < n; ++b) load_history<V, Law>(list.history, found + b * W, batches[b].history);
    Law::template stages<V, kLedger>(constants, [&](auto stage) {
        for (int b = 0; b < n; ++b) stage(batches[b], parameters(batches[b]));
    });
    if (advance)
        for (int b = 0; b < n; ++b) store_history<V, Law>(batches[b].history, list.history, found + b * W);
}

} // namespace talus::core::kernel
