// core/kernel_impl.hpp: the force kernels, templates over the lanes and the law. Included by one source a width.
#pragma once

#include "core/kernel_batch.hpp"
#include "core/kernel_build.hpp"
#include "core/law/choose.hpp"

namespace talus::core::kernel {

template <class V, class Law, bool kLedger>
TALUS_FLATTEN void pair_forces(const ForceContext& context, const TileForces& tile, ContactList& list, HeatSum& heat, CapBreach& breach) {
    constexpr int W = kLanes<V>;
    // What the loops read of the context and the tile, as locals: stores of sums cannot alias them.
    const TileGrains& grains = *tile.grains;
    ForceSum* const sums = tile.sums;
    const Periods periods = context.periods;
    const double force_scale = context.units.force.scale, torque_scale = context.units.torque.scale;
    const bool own_radius = context.laws.rolling_radius == RollingRadius::own;
    const bool mixed = grains.material < 0, advance = context.advance;
    const StepConstants<V> constants = step_constants<V>(context);
    const ContactParameters<V> shared = mixed ? ContactParameters<V>{} : splat_parameters<V>(context.pairs[grains.material][grains.material]);
    const auto pair_table = [&](TileLocal i, TileLocal j) { return &context.pairs[material_of(grains.spin[i])][material_of(grains.spin[j])]; };
    const auto load_ids = [](const CandidatePair* pairs, TileLocal (&i)[W], TileLocal (&j)[W]) {
        for (int l = 0; l < W; ++l) {
            i[l] = pairs[l].i;
            j[l] = pairs[l].j;
        }
    };

    // Where no pair of a tile can be nearer across a period, the search for images is left out.
    const bool has_images = grains.spans_images(periods);
    const auto for_images = [&](auto use) { has_images ? use(periods) : use(NoPeriods{}); };

    for_images([&](const auto& images) {
        admit_touching(list, [&](std::uint32_t first) {
            unsigned mask = 0;
            for (int part = 0; part < 8; part += W) {
                TileLocal i[W], j[W];
                load_ids(&list.candidates[first + part], i, j);
                V p[4], q[4];
                load_grains(grains.centre, i, p);
                load_grains(grains.centre, j, q);
                mask |= bits_of(touches<V>(images, vector_of(p), p[3], vector_of(q), q[3])) << part;
            }
            return mask;
        });
    });

    const CandidatePair* const pairs = list.contacts.data();
    const auto begin = [&](Batch<V>& x, const auto& images) {
        load_ids(pairs + x.first, x.i, x.j);
        V p[4], q[4];
        load_grains(grains.centre, x.i, p);
        load_grains(grains.centre, x.j, q);
        x.radius_i = p[3];
        x.radius_j = q[3];
        return bits_of(set_overlap(images, vector_of(p), p[3], vector_of(q), q[3], x.geometry));
    };
    const auto ended = [&](std::uint32_t contact) {
        if constexpr (kLedger)
            if (tile.index_of[pairs[contact].i] < tile.n_owned) add_released<Law>(context, *pair_table(pairs[contact].i, pairs[contact].j), list, contact, heat);
    };
    Batch<V> batches[kBlock<V> / W];
    for (std::uint32_t block = 0; block < list.n_contacts; block += kBlock<V>) {
        Batch<V>* end = batches;
        for_images([&](const auto& images) { end = begin_batches<V, Law::kHistoryDoubles>(list, block, batches, [&](Batch<V>& x) { return begin(x, images); }, ended); });
        V p[4], q[4];
        for (Batch<V>* x = batches; x != end; ++x) {
            load_grains(grains.motion, x->i, p);
            load_grains(grains.motion, x->j, q);
            x->mass_i = p[3];
            x->mass_j = q[3];
            set_approach(vector_of(p), vector_of(q), x->geometry);
            set_scales<Law::kNeedsInertia>(x->radius_i, x->mass_i, x->radius_j, x->mass_j, own_radius, x->geometry);
            load_grains(grains.spin, x->i, p);
            load_grains(grains.spin, x->j, q);
            set_spin(vector_of(p), x->radius_i, vector_of(q), x->radius_j, x->geometry);
        }
        if (mixed)
            for (Batch<V>* x = batches; x != end; ++x) {
                const PairParameters* tables[W];
                for (int l = 0; l < W; ++l) tables[l] = pair_table(x->i[l], x->j[l]);
                x->parameters = load_parameters<V>(tables);
            }
        run_law<V, Law, kLedger>(batches, end, list, constants, advance, [&](const Batch<V>& x) -> const ContactParameters<V>& { return mixed ? x.parameters : shared; });

        for (const Batch<V>* x = batches; x != end; ++x) {
            const ContactForce<V>& f = x->force;
            const Vec3<V> twist = cross(x->geometry.normal, f.tangential);
            const Vec3<V> on_i = fnma(twist, x->radius_i, f.moment_i), on_j = fnma(twist, x->radius_j, f.moment_j);
            if (!all_within(cap_share(f.force, force_scale) + cap_share(on_i, torque_scale) + cap_share(on_j, torque_scale))) [[unlikely]] {
                const unsigned bad = (beyond_cap(f.force, force_scale) | beyond_cap(on_i, torque_scale) | beyond_cap(on_j, torque_scale)) & x->lanes;
                const V size = square_root(dot(f.force, f.force));
                const auto label = [&](TileLocal id) { return tile.particles[tile.index_of[id]].label; };
                for (int l = 0; l < W; ++l)
                    if (bad >> l & 1) note_breach(breach, label(x->i[l]), label(x->j[l]), lane(size, l));
                if (bad != 0) continue;
            }
            I4 force[W], torque_i[W], torque_j[W];
            integer_rows(f.force, force_scale, x->lanes, force);
            integer_rows(on_i, torque_scale, x->lanes, torque_i);
            integer_rows(on_j, torque_scale, x->lanes, torque_j);
            for (int l = 0; l < W; ++l) {
                ForceSum& si = sums[x->i[l]];
                ForceSum& sj = sums[x->j[l]];
                add_row(si.force, force[l]);
                add_row(si.torque, torque_i[l]);
                subtract_row(sj.force, force[l]);
                add_row(sj.torque, torque_j[l]);
            }
            if (kLedger && advance) {
                // A pair across subdomains is evaluated on both; its heat counts where its smaller label lives.
                unsigned owned = 0;
                for (int l = 0; l < W; ++l) owned |= (tile.index_of[x->i[l]] < tile.n_owned ? 1u : 0u) << l;
                add_heat(x->heat, torque_scale, x->lanes & owned, heat);
            }
        }
    }
}

template <class V, class Law, bool kLedger>
TALUS_FLATTEN void wall_forces(const ForceContext& context, const WallPlane& wall, int wall_id, const TileForces& tile, ContactList& list,
                 WallSum& sum, HeatSum& heat, CapBreach& breach) {
    constexpr int W = kLanes<V>;
    const TileGrains& grains = *tile.grains;
    const double force_scale = context.units.force.scale, torque_scale = context.units.torque.scale;
    const bool advance = context.advance;
    const StepConstants<V> constants = step_constants<V>(context);
    const auto table = [&](TileLocal i) { return &context.pairs[material_of(grains.spin[i])][wall.material]; };

    admit_touching(list, [&](std::uint32_t first) {
        unsigned mask = 0;
        for (int part = 0; part < 8; part += W) {
            TileLocal i[W];
            for (int l = 0; l < W; ++l) i[l] = list.candidates[first + part + l].i;
            V p[4];
            load_grains(grains.centre, i, p);
            mask |= bits_of(touches_plane(wall.point, wall.normal, vector_of(p), p[3])) << part;
        }
        return mask;
    });

    const CandidatePair* const pairs = list.contacts.data();
    const auto begin = [&](Batch<V>& x) {
        const PairParameters* tables[W];
        for (int l = 0; l < W; ++l) {
            x.i[l] = pairs[x.first + l].i;
            tables[l] = table(x.i[l]);
        }
        x.parameters = load_parameters<V>(tables);
        V p[4], q[4], r[4];
        load_grains(grains.centre, x.i, p);
        load_grains(grains.motion, x.i, q);
        load_grains(grains.spin, x.i, r);
        x.radius_i = p[3];
        x.geometry = wall_geometry<Law::kNeedsInertia>(wall.point, wall.normal, wall.velocity, GrainLanes<V>{vector_of(p), p[3], vector_of(q), q[3], vector_of(r)});
        return bits_of(touches_plane(wall.point, wall.normal, vector_of(p), p[3]));
    };
    const auto ended = [&](std::uint32_t contact) {
        if constexpr (kLedger) add_released<Law>(context, *table(pairs[contact].i), list, contact, heat);
    };
    Batch<V> batches[kBlock<V> / W];
    for (std::uint32_t block = 0; block < list.n_contacts; block += kBlock<V>) {
        Batch<V>* const end = begin_batches<V, Law::kHistoryDoubles>(list, block, batches, begin, ended);
        run_law<V, Law, kLedger>(batches, end, list, constants, advance, [](const Batch<V>& x) -> const ContactParameters<V>& { return x.parameters; });

        for (const Batch<V>* x = batches; x != end; ++x) {
            sum.contacts += std::popcount(x->lanes);
            const ContactForce<V>& f = x->force;
            const Vec3<V> on_i = fnma(cross(x->geometry.normal, f.tangential), x->radius_i, f.moment_i);
            if (!all_within(cap_share(f.force, force_scale) + cap_share(on_i, torque_scale))) [[unlikely]] {
                const unsigned bad = (beyond_cap(f.force, force_scale) | beyond_cap(on_i, torque_scale)) & x->lanes;
                const V size = square_root(dot(f.force, f.force));
                for (int l = 0; l < W; ++l)
                    if (bad >> l & 1) note_breach(breach, tile.particles[tile.index_of[x->i[l]]].label, kWallLabel + wall_id, lane(size, l));
                if (bad != 0) continue;
            }
            V p[4];
            load_grains(grains.centre, x->i, p);
            const Vec3<V> at = fnma(x->geometry.normal, x->radius_i - x->geometry.overlap, vector_of(p));
            I4 force[W], torque[W], about_origin[W];
            integer_rows(f.force, force_scale, x->lanes, force);
            integer_rows(on_i, torque_scale, x->lanes, torque);
            integer_rows(cross(at, f.force), context.units.wall_torque.scale, x->lanes, about_origin);
            for (int l = 0; l < W; ++l) {
                ForceSum& si = tile.sums[x->i[l]];
                add_row(si.force, force[l]);
                add_row(si.torque, torque[l]);
                for (int c = 0; c < 3; ++c) {
                    sum.force[c] -= force[l][c];
                    sum.torque[c] -= about_origin[l][c];
                }
            }
            if (kLedger && advance) add_heat(x->heat, torque_scale, x->lanes, heat);
        }
    }
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
