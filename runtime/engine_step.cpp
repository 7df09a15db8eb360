// The loop over steps. Between two firings of the graph one thread per rank decides what is global, from a reduction that was
// started a firing ago: rebuild, stop, errors. So no rank waits for a reduction within a step, and all decide alike.
#include <array>
#include <bit>
#include <cmath>

#include "runtime/engine.hpp"
#include "runtime/large_array.hpp"
#include "runtime/phase/phases.hpp"

namespace talus::runtime {

using core::ErrorKind;

struct Engine::Verdict {
    bool rebuild = false, stop = false, failed = false;
};

namespace {
enum Reduced : int { kSeverity, kSkinUse, kStop, kBusiest, kMinusIdlest, kRebuild, kMinusLow, kHigh = kMinusLow + 3, kReduced = kHigh + 3 };
} // namespace

std::vector<double> Engine::local_verdict() {
    EngineState& s = *state_;
    verdict_step_ = s.model.step;
    std::vector<double> v(kReduced, 0.0);
    const SkinUse use = skin_use(s);
    if (use.now > 1.0)
        s.errors.set(ErrorKind::unstable, fmt::format("step {}: a grain of rank {} outran the list: relative displacement {:.3g} of the skin {} m within a step; reduce the time step or widen the skin", s.model.step + 1, s.comm->rank(), use.now, s.model.skin()));
    v[kSeverity] = s.errors.severity();
    v[kSkinUse] = use.foreseen;
    v[kStop] = stop_requested_.load(std::memory_order_relaxed) ? 1.0 : 0.0;
    const LoadOpinion load = load_opinion(s, verdict_step_ - s.watch.built_step);
    v[kBusiest] = load.busy;
    v[kMinusIdlest] = -load.busy;
    v[kRebuild] = load.rebuild;
    for (int a = 0; a < 3; ++a) {
        v[kMinusLow + a] = use.all.empty() ? -HUGE_VAL : -std::min(use.all.lo[a], use.all.foreseen_lo[a]);
        v[kHigh + a] = use.all.empty() ? -HUGE_VAL : std::max(use.all.hi[a], use.all.foreseen_hi[a]);
    }
    return v;
}

Engine::Verdict Engine::agree_on_step(const std::vector<double>& reduced) {
    Verdict v;
    v.failed = reduced[kSeverity] > 0.0;
    // Grains of tiles that are not neighbours, on this rank or on others, start at least two reaches apart. They come to touch only
    // after a relative displacement above one reach: a lone fast grain is seen by this and by nothing else.
    double apart = 0.0;
    for (int a = 0; a < 3; ++a) {
        const double width = reduced[kHigh + a] + reduced[kMinusLow + a];
        apart += std::isfinite(width) ? width * width : 0.0;
    }
    const double reach = state_->model.reach();
    const std::int64_t served = verdict_step_ - state_->watch.built_step;
    const bool outlived = watch_lists(*state_, served, reduced[kSkinUse], std::sqrt(apart)) ||
                          (reduced[kBusiest] > 0.0 && outlived_balance(*state_, served, reduced[kBusiest], -reduced[kMinusIdlest], reduced[kRebuild]));
    v.rebuild = !(reduced[kSkinUse] < 1.0) || !(apart < reach * reach) || outlived;
    v.stop = reduced[kStop] > 0.0;
    return v;
}

/// A firing without forces.
static void integrate_between(EngineState& s, bool finish, bool begin) {
    s.with_forces = false;
    s.integrate.finish = finish;
    s.integrate.begin = begin;
    s.graph->fire();
}

void Engine::collect_walls(bool count_impulse) {
    EngineState& s = *state_;
    auto& last = s.sub.wall_last;
    last.assign(s.model.walls.size(), core::WallSum{});
    s.sub.wall_impulse.resize(3 * s.model.walls.size(), 0);
    for (const core::Tile& tile : s.sub.tiles)
        for (std::size_t w = 0; w < last.size(); ++w) {
            for (int c = 0; c < 3; ++c) {
                last[w].force[c] += tile.wall_sums[w].force[c];
                last[w].torque[c] += tile.wall_sums[w].torque[c];
            }
            last[w].contacts += tile.wall_sums[w].contacts;
        }
    if (!count_impulse) return;
    for (std::size_t w = 0; w < last.size(); ++w)
        for (int c = 0; c < 3; ++c) s.sub.wall_impulse[3 * w + c] += last[w].force[c];
}

bool Engine::step(std::int64_t n_steps, std::int64_t& done) {
    done = 0;
    require_healthy();
    EngineState& s = *state_;
    require_same(*s.comm, "n_steps", std::array{static_cast<double>(n_steps)});
    if (n_steps < 0) core::fail(ErrorKind::argument, "n_steps = {}: must be >= 0", n_steps);
    prepare();
    if (n_steps == 0) return false;
    ++generation_;
    try {
        refresh_contexts(s);
        Verdict verdict;
        if (verdict_stale_) {
            s.comm->start_max(local_verdict());
            verdict = agree_on_step(s.comm->finish_max());
            verdict_stale_ = false;
        } else {
            verdict.rebuild = rebuild_due_;
        }
        // First half kick and drift of the first step, with the second half kick of the step before if nobody has asked for its
        // velocities; from then on each firing ends with those of the next.
        integrate_between(s, kick_due_, true);
        kick_due_ = false;
        s.halo_under_way = s.parallel();

        bool last = false, stop = false, pending = false;
        for (;;) {
            for (Wall& w : s.model.walls) {
                double* x[3] = {&w.plane.point.x, &w.plane.point.y, &w.plane.point.z};
                const double v[3] = {w.plane.velocity.x, w.plane.velocity.y, w.plane.velocity.z};
                for (int a = 0; a < 3; ++a) *x[a] += s.model.settings.time_step * v[a];
            }
            if (pending) {
                verdict = agree_on_step(s.comm->finish_max());
                pending = false;
                if (verdict.failed) break;
                stop = stop || verdict.stop;
            }
            last = stop || done + 1 == n_steps;
            if (verdict.rebuild) {
                if (s.halo_under_way) s.halo.drain();
                s.halo_under_way = false;
                rebuild(s, false, false);
                verdict.rebuild = false;
            }
            if (!last) {
                s.comm->start_max(local_verdict());
                pending = true;
            }

            s.with_forces = true;
            s.integrate.finish = s.integrate.begin = !last;
            s.graph->fire();
            kick_due_ = ghosts_behind_ = last;
            s.halo_under_way = s.parallel() && !last;
            collect_walls(true);
            ++s.model.step;
            s.model.time += s.model.settings.time_step;
            ++done;
            if (trace_left_ > 0 && --trace_left_ == 0) write_trace();
            if (last) break;
        }
        // What this rank still does not know of the last step.
        if (s.halo_under_way) {
            s.halo.drain();
            s.halo_under_way = false;
        }
        s.comm->start_max(local_verdict());
        const Verdict end = agree_on_step(s.comm->finish_max());
        rebuild_due_ = end.rebuild;
        if (end.failed || verdict.failed) agree_on(*s.comm, s.errors.severity(), s.errors.message());
        const bool stopped = stop || end.stop;
        if (stopped) stop_requested_.store(false, std::memory_order_relaxed);
        return stopped; // with the last step too: the request is used up, and nobody else would hear of it
    } catch (...) {
        poisoned_ = true;
        throw;
    }
}

std::int64_t Engine::steps_until(double time) {
    constexpr double kShort = 1e-6; // of a step
    const Model& m = state_->model;
    require_same(*state_->comm, "time", std::array{time});
    if (!std::isfinite(time)) core::fail(ErrorKind::argument, "time = {}: must be finite", time);
    const double steps = std::ceil((time - m.time) / m.settings.time_step - kShort);
    if (steps > 0x1p62) core::fail(ErrorKind::argument, "time = {} s is {} steps away", time, steps);
    return steps > 0.0 ? static_cast<std::int64_t>(steps) : 0;
}

void Engine::finish_step() {
    if (!kick_due_ || poisoned_) return;
    integrate_between(*state_, true, false);
    kick_due_ = false;
}

void Engine::first_forces() {
    EngineState& s = *state_;
    refresh_contexts(s);
    s.force.dt = 0.0;
    s.force.advance = false;
    s.with_forces = true;
    s.integrate.finish = false;
    s.integrate.begin = false;
    s.graph->fire();
    collect_walls(false);
    try {
        agree_on(*s.comm, s.errors.severity(), s.errors.message());
    } catch (...) {
        poisoned_ = true;
        throw;
    }
}

namespace {

/// The nodes of a step follow the tiles and neighbours; a graph that still fits is kept.
void renew_graph(EngineState& s) {
    GraphShape shape;
    shape.talks = s.parallel() && s.halo.talks();
    shape.parts = s.halo.n_parts();
    for (const core::Tile& t : s.sub.tiles) {
        shape.neighbours.push_back(t.neighbours);
        shape.sees_ghosts.push_back(!t.ghost_chunks.empty());
    }
    for (int k = 0; k < s.halo.n_neighbours(); ++k) shape.tiles_of_send.push_back(s.halo.tiles_of(k));
    if (s.graph && s.graph->shape() == shape) return;

    StepHooks hooks;
    hooks.integrate = [&s](int t) { integrate_tile(s, t); };
    hooks.worked = [&s](int t, double seconds) { s.sub.tiles[t].seconds += seconds; };
    const auto guarded = [&s](auto body) {
        try {
            body();
        } catch (const core::Error& e) {
            s.errors.set(e.kind(), e.what());
        } catch (const std::exception& e) {
            s.errors.set(ErrorKind::internal, e.what());
        }
    };
    hooks.force = [&s](int t) {
        s.workers.muster(static_cast<int>(s.sub.tiles.size()));
        force_tile(s, t);
    };
    hooks.send = [&s, guarded](int k) {
        if (s.integrate.begin) guarded([&] { s.halo.send(k, s.sub); });
    };
    hooks.halo_arrived = [&s, guarded] {
        bool arrived = true;
        guarded([&] { arrived = s.halo.arrived(); });
        return arrived;
    };
    hooks.halo_take = [&s](int part) {
        if (s.halo_under_way) s.halo.take(part, s.sub);
    };
    hooks.halo_taken = [&s, guarded] {
        if (s.integrate.begin) guarded([&] { s.halo.start_receives(); });
    };
    s.graph.reset();
    s.graph = std::make_unique<StepGraph>(s.workers, std::move(shape), std::move(hooks));
}

} // namespace

void rebuild(EngineState& s, bool first, bool keep_sums) {
    const auto from = Workers::Clock::now();
    empty_tiles(s, keep_sums);
    choose_skin(s);
    rebalance(s, first);
    agree(*s.comm, [&] { bin_grains(s); });
    s.workers.timed(Phase::halo_exchange, 0, [&] { s.halo.build(s.slices, s.model.settings.domain, s.model.reach(), s.sub); });
    agree(*s.comm, [&] {
        trim(s.sub.particles);
        trim(s.sub.references);
        build_pairs(s);
    });
    ++s.counters.rebuilds;
    // Lists of a new size leave holes, the first ones above all; and the system gives pages slowly, so not every time.
    if (std::has_single_bit(static_cast<std::uint64_t>(s.counters.rebuilds))) return_free_memory();
    renew_graph(s);
    const double seconds = std::chrono::duration<double>(Workers::Clock::now() - from).count();
    begin_watch(s, s.workers.threads() * seconds); // threads that have nothing to do in a rebuild cannot do anything else
    begin_load(s, seconds);
}

void refresh_contexts(EngineState& s) {
    const Settings& set = s.model.settings;
    core::ForceContext& f = s.force;
    f.laws = set.laws;
    f.periods = core::Periods(set.domain);
    f.units = s.model.units;
    f.dt = set.time_step;
    f.advance = true;
    f.ledger = set.energy_ledger;
    f.n_materials = static_cast<int>(s.model.materials.size());
    core::IntegrateContext& i = s.integrate;
    i.domain = set.domain;
    i.units = s.model.units;
    i.groups = s.model.groups;
    for (int a = 0; a < 3; ++a) i.gravity[a] = set.gravity[a];
    i.dt = set.time_step;
    s.kernels = core::select_kernels(set.laws, set.energy_ledger, set.width);
}

} // namespace talus::runtime
