// core/kernel_impl.hpp: the body of the force kernels, a template over the lanes and the law. Included by one source a width.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

#include "core/contact_lanes.hpp"
#include "core/error.hpp"
#include "core/force_kernel.hpp"
#include "core/law/choose.hpp"

// Laws, transposes and history rows must be inlined into the loops: as calls they pass vectors through memory, at half the speed.
// Where nobody looks at speed (sanitizers, builds that are not optimised), compiling that takes minutes for nothing.
#if defined(NDEBUG) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define TALUS_FLATTEN [[gnu::flatten]]
#else
#define TALUS_FLATTEN
#endif

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

/// Candidates that are filtered before their contacts are evaluated: few enough that what the filter fetched is still in L1.
inline constexpr std::uint32_t kBlock = 64;

/// Find the touching entries of a list and hand them on, W at a time. `touch8(first)` gives the touching bits of eight entries;
/// `fetch(entry)` asks for what evaluating the entry will read; `ended(entry)` is told of each contact that ends, while its row
/// still stands; `evaluate(entries, lanes)` gets W entries, of which the first `lanes` count.
/// @return number of touching entries
template <int W, int kHistory, class Touch8, class Fetch, class Ended, class Evaluate>
inline std::uint32_t for_contacts(const ContactList& list, Touch8 touch8, Fetch fetch, Ended ended, Evaluate evaluate) {
    std::uint32_t found[kBlock + 2 * 8];
    std::uint32_t n = 0, total = 0;
    for (std::uint32_t block = 0; block < list.count; block += kBlock) {
        const std::uint32_t end = std::min(block + kBlock, list.count);
        for (std::uint32_t first = block; first < end; first += 8) {
            const std::uint32_t left = list.count - first;
            for (std::uint32_t k = 0; k < 8; ++k) fetch(first + k);
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
        total += n;
        const bool last = end == list.count;
        // A batch that is not full waits for the next block; the last one is filled by repetition.
        if (last && n > 0)
            for (std::uint32_t k = n; k % W != 0; ++k) found[k] = found[n - 1];
        std::uint32_t done = 0;
        for (; done + W <= n || (last && done < n); done += W) evaluate(found + done, static_cast<int>(std::min<std::uint32_t>(W, n - done)));
        const std::uint32_t rest = done < n ? n - done : 0;
        for (std::uint32_t k = 0; k < rest; ++k) found[k] = found[done + k];
        total -= rest;
        n = rest;
    }
    return total;
}

template <class V>
inline StepConstants<V> step_constants(const ForceContext& c) {
    const double floor = c.laws.damping == Damping::clipped ? 0.0 : -std::numeric_limits<double>::infinity();
    return {splat<V>(c.dt), splat<V>(floor), splat<V>(c.laws.rolling_rate)};
}

template <class V, class Law>
inline ContactHistory<V> load_history(const double* history, const std::uint32_t* entry) {
    ContactHistory<V> h{};
    if constexpr (Law::kHistoryDoubles > 0) {
        const double* rows[kLanes<V>];
        V q[4];
        for (int l = 0; l < kLanes<V>; ++l) rows[l] = history + static_cast<std::size_t>(entry[l]) * Law::kHistoryDoubles;
        load_columns(rows, q);
        h.tangential = {{q[0], q[1], q[2]}, q[3]};
        if constexpr (Law::kHistoryDoubles > 4) {
            for (int l = 0; l < kLanes<V>; ++l) rows[l] += 4;
            load_columns(rows, q);
            h.rolling = {q[0], q[1], q[2]};
        }
    }
    return h;
}

template <class V, class Law>
inline void store_history(const ContactHistory<V>& h, double* history, const std::uint32_t* entry, int lanes) {
    if constexpr (Law::kHistoryDoubles > 0) {
        alignas(64) double rows[kLanes<V>][4];
        const auto put = [&](const V(&columns)[4], int offset) {
            to_rows(columns, rows);
            for (int l = 0; l < lanes; ++l) {
                double* row = history + static_cast<std::size_t>(entry[l]) * Law::kHistoryDoubles + offset;
                for (int c = 0; c < 4; ++c) row[c] = rows[l][c];
            }
        };
        put({h.tangential.vector.x, h.tangential.vector.y, h.tangential.vector.z, h.tangential.last}, 0);
        if constexpr (Law::kHistoryDoubles > 4) put({h.rolling.x, h.rolling.y, h.rolling.z, splat<V>(0.0)}, 4);
    }
}

/// Three columns of a force or torque as integer rows (x, y, z, 0).
template <class V>
inline void integer_rows(const Vec3<V>& v, double scale, std::int64_t (&rows)[kLanes<V>][4]) {
    using Int = typename Lanes<V>::Int;
    const V s = splat<V>(scale);
    const Int columns[4] = {to_integer(v.x * s), to_integer(v.y * s), to_integer(v.z * s), Int{}};
    to_rows(columns, rows);
}

/// Lanes in which a force or torque is within the cap in every component. Not-a-number fails every comparison, so the test is for
/// what is right.
template <class V>
inline Mask<V> within_cap(const Vec3<V>& v, double scale) {
    const V s = splat<V>(scale), cap = splat<V>(kCapUnits);
    return (magnitude(v.x * s) <= cap) & (magnitude(v.y * s) <= cap) & (magnitude(v.z * s) <= cap);
}
/// Bits of the first `lanes` lanes that are not in the mask.
template <class V>
inline unsigned lanes_outside(Mask<V> fine, int lanes) {
    return ~bits_of(fine) & ((1u << lanes) - 1u);
}

inline void add_row(std::int64_t* sum, const std::int64_t* row) {
    for (int c = 0; c < 4; ++c) sum[c] += row[c];
}
inline void subtract_row(std::int64_t* sum, const std::int64_t* row) {
    for (int c = 0; c < 4; ++c) sum[c] -= row[c];
}

template <class V>
inline void add_heat(const Dissipation<V>& d, double scale, unsigned lanes, HeatSum& heat) {
    alignas(64) std::int64_t rows[kLanes<V>][4];
    integer_rows(Vec3<V>{d.friction, d.damping, d.rolling}, scale, rows);
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

template <class V, class Law, bool kLedger>
TALUS_FLATTEN void pair_forces(const ForceContext& context, const TileForces& tile, HeatSum& heat, CapBreach& breach) {
    constexpr int W = kLanes<V>;
    constexpr bool kInertia = Law::kHistoryDoubles > 4;
    // What the loop reads of the context and the tile, as locals: stores of sums cannot alias them.
    const Particle* const particles = tile.particles;
    const LocalIndex* const index_of = tile.index_of;
    ForceSum* const sums = tile.sums;
    const ContactList list = tile.contacts;
    const Periods periods = context.periods;
    const double force_scale = context.units.force.scale, torque_scale = context.units.torque.scale;
    const bool own_radius = context.laws.rolling_radius == RollingRadius::own;
    const bool one_material = context.n_materials == 1, advance = context.advance;
    const StepConstants<V> constants = step_constants<V>(context);
    const ContactParameters<V> shared = splat_parameters<V>(context.pairs[0][0]);

    const auto touch8 = [&](std::uint32_t first) {
        unsigned mask = 0;
        for (int part = 0; part < 8; part += W) {
            const double *a[W], *b[W];
            for (int l = 0; l < W; ++l) {
                const CandidatePair pair = list.pairs[first + part + l];
                a[l] = particles[index_of[pair.a]].position;
                b[l] = particles[index_of[pair.b()]].position;
            }
            V p[4], q[4];
            load_columns(a, p);
            load_columns(b, q);
            mask |= bits_of(touches<V>(periods, {p[0], p[1], p[2]}, p[3], {q[0], q[1], q[2]}, q[3])) << part;
        }
        return mask;
    };
    const auto ended = [&](std::uint32_t entry) {
        if constexpr (kLedger) {
            const CandidatePair pair = list.pairs[entry];
            const LocalIndex a = index_of[pair.a], b = index_of[pair.b()];
            if ((pair.flipped() ? b : a) < tile.n_owned) add_released<Law>(context, context.pairs[material_of(particles[a])][material_of(particles[b])], list, entry, heat);
        }
    };
    const auto fetch = [&](std::uint32_t entry) {
        const TileLocal b = list.pairs[entry + kFetchAhead].b();
        const Particle& p = particles[index_of[b]];
        __builtin_prefetch(p.position);
        __builtin_prefetch(p.angular_velocity);
        __builtin_prefetch(&sums[b], 1);
        if constexpr (Law::kHistoryDoubles > 0) __builtin_prefetch(list.history + static_cast<std::size_t>(entry + kFetchAhead) * Law::kHistoryDoubles, 1);
    };
    const auto evaluate = [&](const std::uint32_t* found, int lanes) {
        const Particle *pi[W], *pj[W];
        TileLocal ti[W], tj[W];
        for (int l = 0; l < W; ++l) {
            const CandidatePair pair = list.pairs[found[l]];
            const TileLocal a = pair.a, b = pair.b();
            ti[l] = pair.flipped() ? b : a;
            tj[l] = pair.flipped() ? a : b;
            pi[l] = &particles[index_of[ti[l]]];
            pj[l] = &particles[index_of[tj[l]]];
        }
        const GrainLanes<V> gi = load_grains<V>(pi), gj = load_grains<V>(pj);
        const ContactGeometry<V> g = pair_geometry<kInertia>(periods, gi, gj, own_radius);
        ContactParameters<V> parameters = shared;
        if (!one_material) {
            const PairParameters* tables[W];
            for (int l = 0; l < W; ++l) tables[l] = &context.pairs[material_of(*pi[l])][material_of(*pj[l])];
            parameters = load_parameters<V>(tables);
        }
        ContactHistory<V> history = load_history<V, Law>(list.history, found);
        Dissipation<V> dissipated;
        const ContactForce<V> f = Law::evaluate(g, parameters, constants, history, kLedger ? &dissipated : nullptr);

        const Vec3<V> twist = cross(g.normal, f.tangential);
        const Vec3<V> on_i = fnma(twist, gi.radius, f.moment_i), on_j = fnma(twist, gj.radius, f.moment_j);
        const Mask<V> fine = within_cap(f.force, force_scale) & within_cap(on_i, torque_scale) & within_cap(on_j, torque_scale);
        if (const unsigned bad = lanes_outside<V>(fine, lanes); bad != 0) [[unlikely]] {
            const V size = square_root(dot(f.force, f.force));
            for (int l = 0; l < lanes; ++l)
                if (bad >> l & 1) note_breach(breach, pi[l]->label, pj[l]->label, lane(size, l));
            return;
        }
        alignas(64) std::int64_t force[W][4], torque_i[W][4], torque_j[W][4];
        integer_rows(f.force, force_scale, force);
        integer_rows(on_i, torque_scale, torque_i);
        integer_rows(on_j, torque_scale, torque_j);
        for (int l = 0; l < lanes; ++l) {
            ForceSum& si = sums[ti[l]];
            ForceSum& sj = sums[tj[l]];
            add_row(si.force, force[l]);
            add_row(si.torque, torque_i[l]);
            subtract_row(sj.force, force[l]);
            add_row(sj.torque, torque_j[l]);
        }
        if (advance) store_history<V, Law>(history, list.history, found, lanes);
        if (kLedger && advance) {
            // A pair across subdomains is evaluated on both; its heat counts where its smaller label lives.
            unsigned owned = 0;
            for (int l = 0; l < lanes; ++l) owned |= (index_of[ti[l]] < tile.n_owned ? 1u : 0u) << l;
            add_heat(dissipated, torque_scale, owned, heat);
        }
    };
    for_contacts<W, Law::kHistoryDoubles>(list, touch8, fetch, ended, evaluate);
}

template <class V, class Law, bool kLedger>
TALUS_FLATTEN void wall_forces(const ForceContext& context, const WallPlane& wall, int wall_id, const TileForces& tile,
                 WallSum& sum, HeatSum& heat, CapBreach& breach) {
    constexpr int W = kLanes<V>;
    constexpr bool kInertia = Law::kHistoryDoubles > 4;
    const Particle* const particles = tile.particles;
    const LocalIndex* const index_of = tile.index_of;
    const ContactList list = tile.contacts;
    const double force_scale = context.units.force.scale, torque_scale = context.units.torque.scale;
    const StepConstants<V> constants = step_constants<V>(context);

    const auto touch8 = [&](std::uint32_t first) {
        unsigned mask = 0;
        for (int part = 0; part < 8; part += W) {
            const double* a[W];
            for (int l = 0; l < W; ++l) a[l] = particles[index_of[list.pairs[first + part + l].a]].position;
            V p[4];
            load_columns(a, p);
            mask |= bits_of(height_above<V>(wall.point, wall.normal, {p[0], p[1], p[2]}) < p[3]) << part;
        }
        return mask;
    };
    const auto ended = [&](std::uint32_t entry) {
        if constexpr (kLedger) add_released<Law>(context, context.pairs[material_of(particles[index_of[list.pairs[entry].a]])][wall.material], list, entry, heat);
    };
    // A tile's grains stand in the order of its wall list: the hardware sees them coming.
    const auto fetch = [](std::uint32_t) {};
    const auto evaluate = [&](const std::uint32_t* found, int lanes) {
        const Particle* pi[W];
        const PairParameters* tables[W];
        for (int l = 0; l < W; ++l) {
            pi[l] = &particles[index_of[list.pairs[found[l]].a]];
            tables[l] = &context.pairs[material_of(*pi[l])][wall.material];
        }
        const GrainLanes<V> gi = load_grains<V>(pi);
        const ContactGeometry<V> g = wall_geometry<kInertia>(wall.point, wall.normal, wall.velocity, gi);
        ContactHistory<V> history = load_history<V, Law>(list.history, found);
        Dissipation<V> dissipated;
        const ContactForce<V> f = Law::evaluate(g, load_parameters<V>(tables), constants, history, kLedger ? &dissipated : nullptr);

        const Vec3<V> twist = cross(g.normal, f.tangential);
        const Vec3<V> on_i = fnma(twist, gi.radius, f.moment_i);
        const Mask<V> fine = within_cap(f.force, force_scale) & within_cap(on_i, torque_scale);
        if (const unsigned bad = lanes_outside<V>(fine, lanes); bad != 0) [[unlikely]] {
            const V size = square_root(dot(f.force, f.force));
            for (int l = 0; l < lanes; ++l)
                if (bad >> l & 1) note_breach(breach, pi[l]->label, kWallLabel + wall_id, lane(size, l));
            return;
        }
        const Vec3<V> at = fnma(g.normal, gi.radius - g.overlap, gi.position);
        alignas(64) std::int64_t force[W][4], torque[W][4], about_origin[W][4];
        integer_rows(f.force, force_scale, force);
        integer_rows(on_i, torque_scale, torque);
        integer_rows(cross(at, f.force), context.units.wall_torque.scale, about_origin);
        for (int l = 0; l < lanes; ++l) {
            ForceSum& si = tile.sums[list.pairs[found[l]].a];
            add_row(si.force, force[l]);
            add_row(si.torque, torque[l]);
            for (int c = 0; c < 3; ++c) {
                sum.force[c] -= force[l][c];
                sum.torque[c] -= about_origin[l][c];
            }
        }
        if (context.advance) store_history<V, Law>(history, list.history, found, lanes);
        if (kLedger && context.advance) add_heat(dissipated, torque_scale, (1u << lanes) - 1u, heat);
    };
    sum.contacts += for_contacts<W, Law::kHistoryDoubles>(list, touch8, fetch, ended, evaluate);
}

/// What choose_law() makes of a law: the kernels at a width.
template <class V, bool kLedger>
struct MakeKernels {
    template <class Law>
    static KernelSet make() {
        return {&pair_forces<V, Law, kLedger>, &wall_forces<V, Law, kLedger>};
    }
};

template <class V>
KernelSet choose(const Laws& l, bool ledger) {
    return ledger ? choose_law<MakeKernels<V, true>>(l) : choose_law<MakeKernels<V, false>>(l);
}

} // namespace talus::core::kernel
