// core/kernel_impl.hpp: the force kernels, templates over the lanes and the law. Included by one source a width.
#pragma once

#include "core/kernel_batch.hpp"
#include "core/kernel_build.hpp"
#include "core/law/choose.hpp"

namespace talus::core::kernel {

template <class V, class Law, bool kLedger>
TALUS_FLATTEN void pair_forces(const ForceContext& context, const TileForces& tile, HeatSum& heat, CapBreach& breach) {
    constexpr int W = kLanes<V>;
    // What the loops read of the context and the tile, as locals: stores of sums cannot alias them.
    const TileGrains& grains = *tile.grains;
    ForceSum* const sums = tile.sums;
    const ContactList list = tile.contacts;
    const Periods periods = context.periods;
    const double force_scale = context.units.force.scale, torque_scale = context.units.torque.scale;
    const bool own_radius = context.laws.rolling_radius == RollingRadius::own;
    const bool mixed = grains.material < 0, advance = context.advance;
    const StepConstants<V> constants = step_constants<V>(context);
    const ContactParameters<V> shared = mixed ? ContactParameters<V>{} : splat_parameters<V>(context.pairs[grains.material][grains.material]);
    const auto pair_table = [&](TileLocal i, TileLocal j) { return &context.pairs[material_of(grains.spin[i])][material_of(grains.spin[j])]; };

    const auto touch8 = [&](std::uint32_t first) {
        unsigned mask = 0;
        for (int part = 0; part < 8; part += W) {
            TileLocal i[W], j[W];
            for (int l = 0; l < W; ++l) {
                i[l] = list.pairs[first + part + l].i;
                j[l] = list.pairs[first + part + l].j;
            }
            V p[4], q[4];
            load_grains(grains.centre, i, p);
            load_grains(grains.centre, j, q);
            mask |= bits_of(touches<V>(periods, vector_of(p), p[3], vector_of(q), q[3])) << part;
        }
        return mask;
    };
    const auto ended = [&](std::uint32_t entry) {
        if constexpr (kLedger) {
            const CandidatePair pair = list.pairs[entry];
            if (tile.index_of[pair.i] < tile.n_owned) add_released<Law>(context, *pair_table(pair.i, pair.j), list, entry, heat);
        }
    };
    Batch<V> batches[kBlock / W + 1];
    const auto evaluate = [&](const std::uint32_t* found, std::uint32_t count) {
        const int n = static_cast<int>((count + W - 1) / W);
        V p[4], q[4];
        for (int b = 0; b < n; ++b) {
            Batch<V>& x = batches[b];
            for (int l = 0; l < W; ++l) {
                x.i[l] = list.pairs[found[b * W + l]].i;
                x.j[l] = list.pairs[found[b * W + l]].j;
                // Needed four stages on; the list is in order, but with gaps that the hardware does not foresee.
                if constexpr (Law::kHistoryDoubles > 0) __builtin_prefetch(list.history + static_cast<std::size_t>(found[b * W + l]) * Law::kHistoryDoubles, 1);
            }
            load_grains(grains.centre, x.i, p);
            load_grains(grains.centre, x.j, q);
            x.radius_i = p[3];
            x.radius_j = q[3];
            set_overlap(periods, vector_of(p), p[3], vector_of(q), q[3], x.geometry);
        }
        for (int b = 0; b < n; ++b) {
            Batch<V>& x = batches[b];
            load_grains(grains.motion, x.i, p);
            load_grains(grains.motion, x.j, q);
            x.mass_i = p[3];
            x.mass_j = q[3];
            set_approach(vector_of(p), vector_of(q), x.geometry);
        }
        for (int b = 0; b < n; ++b) {
            Batch<V>& x = batches[b];
            load_grains(grains.spin, x.i, p);
            load_grains(grains.spin, x.j, q);
            set_spin(vector_of(p), x.radius_i, vector_of(q), x.radius_j, x.geometry);
        }
        for (int b = 0; b < n; ++b) {
            Batch<V>& x = batches[b];
            set_scales<Law::kNeedsInertia>(x.radius_i, x.mass_i, x.radius_j, x.mass_j, own_radius, x.geometry);
        }
        if (mixed)
            for (int b = 0; b < n; ++b) {
                Batch<V>& x = batches[b];
                const PairParameters* tables[W];
                for (int l = 0; l < W; ++l) tables[l] = pair_table(x.i[l], x.j[l]);
                x.own_parameters = load_parameters<V>(tables);
            }
        run_law<V, Law, kLedger>(batches, n, found, list, constants, advance, [&](const Batch<V>& x) -> const ContactParameters<V>& { return mixed ? x.own_parameters : shared; });

        for (int b = 0; b < n; ++b) {
            const Batch<V>& x = batches[b];
            const int lanes = std::min(W, static_cast<int>(count) - b * W);
            const ContactForce<V>& f = x.force;
            const Vec3<V> twist = cross(x.geometry.normal, f.tangential);
            const Vec3<V> on_i = fnma(twist, x.radius_i, f.moment_i), on_j = fnma(twist, x.radius_j, f.moment_j);
            CapCheck<V> check;
            check.add(f.force, force_scale);
            check.add(on_i, torque_scale);
            check.add(on_j, torque_scale);
            if (const unsigned bad = check.breaches(lanes); bad != 0) [[unlikely]] {
                const V size = square_root(dot(f.force, f.force));
                const auto label = [&](TileLocal id) { return tile.particles[tile.index_of[id]].label; };
                for (int l = 0; l < lanes; ++l)
                    if (bad >> l & 1) note_breach(breach, label(x.i[l]), label(x.j[l]), lane(size, l));
                continue;
            }
            I4 force[W], torque_i[W], torque_j[W];
            integer_rows(f.force, force_scale, lanes, force);
            integer_rows(on_i, torque_scale, lanes, torque_i);
            integer_rows(on_j, torque_scale, lanes, torque_j);
            for (int l = 0; l < W; ++l) {
                ForceSum& si = sums[x.i[l]];
                ForceSum& sj = sums[x.j[l]];
                add_row(si.force, force[l]);
                add_row(si.torque, torque_i[l]);
                subtract_row(sj.force, force[l]);
                add_row(sj.torque, torque_j[l]);
            }
            if (kLedger && advance) {
                // A pair across subdomains is evaluated on both; its heat counts where its smaller label lives.
                unsigned owned = 0;
                for (int l = 0; l < lanes; ++l) owned |= (tile.index_of[x.i[l]] < tile.n_owned ? 1u : 0u) << l;
                add_heat(x.heat, torque_scale, owned, heat);
            }
        }
    };
    for_contacts<W, Law::kHistoryDoubles>(list, touch8, ended, evaluate);
}

template <class V, class Law, bool kLedger>
TALUS_FLATTEN void wall_forces(const ForceContext& context, const WallPlane& wall, int wall_id, const TileForces& tile,
                 WallSum& sum, HeatSum& heat, CapBreach& breach) {
    constexpr int W = kLanes<V>;
    const TileGrains& grains = *tile.grains;
    const ContactList list = tile.contacts;
    const double force_scale = context.units.force.scale, torque_scale = context.units.torque.scale;
    const bool advance = context.advance;
    const StepConstants<V> constants = step_constants<V>(context);
    const auto table = [&](TileLocal i) { return &context.pairs[material_of(grains.spin[i])][wall.material]; };

    const auto touch8 = [&](std::uint32_t first) {
        unsigned mask = 0;
        for (int part = 0; part < 8; part += W) {
            TileLocal i[W];
            for (int l = 0; l < W; ++l) i[l] = list.pairs[first + part + l].i;
            V p[4];
            load_grains(grains.centre, i, p);
            mask |= bits_of(height_above<V>(wall.point, wall.normal, vector_of(p)) < p[3]) << part;
        }
        return mask;
    };
    const auto ended = [&](std::uint32_t entry) {
        if constexpr (kLedger) add_released<Law>(context, *table(list.pairs[entry].i), list, entry, heat);
    };
    Batch<V> batches[kBlock / W + 1];
    const auto evaluate = [&](const std::uint32_t* found, std::uint32_t count) {
        const int n = static_cast<int>((count + W - 1) / W);
        V p[4], q[4], r[4];
        for (int b = 0; b < n; ++b) {
            Batch<V>& x = batches[b];
            const PairParameters* tables[W];
            for (int l = 0; l < W; ++l) {
                x.i[l] = list.pairs[found[b * W + l]].i;
                tables[l] = table(x.i[l]);
            }
            x.own_parameters = load_parameters<V>(tables);
            load_grains(grains.centre, x.i, p);
            load_grains(grains.motion, x.i, q);
            load_grains(grains.spin, x.i, r);
            x.radius_i = p[3];
            x.geometry = wall_geometry<Law::kNeedsInertia>(wall.point, wall.normal, wall.velocity, GrainLanes<V>{vector_of(p), p[3], vector_of(q), q[3], vector_of(r)});
        }
        run_law<V, Law, kLedger>(batches, n, found, list, constants, advance, [](const Batch<V>& x) -> const ContactParameters<V>& { return x.own_parameters; });

        for (int b = 0; b < n; ++b) {
            const Batch<V>& x = batches[b];
            const int lanes = std::min(W, static_cast<int>(count) - b * W);
            const ContactForce<V>& f = x.force;
            const Vec3<V> on_i = fnma(cross(x.geometry.normal, f.tangential), x.radius_i, f.moment_i);
            CapCheck<V> check;
            check.add(f.force, force_scale);
            check.add(on_i, torque_scale);
            if (const unsigned bad = check.breaches(lanes); bad != 0) [[unlikely]] {
                const V size = square_root(dot(f.force, f.force));
                for (int l = 0; l < lanes; ++l)
                    if (bad >> l & 1) note_breach(breach, tile.particles[tile.index_of[x.i[l]]].label, kWallLabel + wall_id, lane(size, l));
                continue;
            }
            load_grains(grains.centre, x.i, p);
            const Vec3<V> at = fnma(x.geometry.normal, x.radius_i - x.geometry.overlap, vector_of(p));
            I4 force[W], torque[W], about_origin[W];
            integer_rows(f.force, force_scale, lanes, force);
            integer_rows(on_i, torque_scale, lanes, torque);
            integer_rows(cross(at, f.force), context.units.wall_torque.scale, lanes, about_origin);
            for (int l = 0; l < W; ++l) {
                ForceSum& si = tile.sums[x.i[l]];
                add_row(si.force, force[l]);
                add_row(si.torque, torque[l]);
                for (int c = 0; c < 3; ++c) {
                    sum.force[c] -= force[l][c];
                    sum.torque[c] -= about_origin[l][c];
                }
            }
            if (kLedger && advance) add_heat(x.heat, torque_scale, (1u << lanes) - 1u, heat);
        }
    };
    sum.contacts += for_contacts<W, Law::kHistoryDoubles>(list, touch8, ended, evaluate);
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
