// Phase timings by Google Benchmark; counters in grains a second. Phases: binning, pair_build (with inheritance), force (each law at
// each width), integrate, halo_exchange and rebalance (which need ranks and cost nothing on one), and the whole step. One rank; a
// phase that runs on several threads is timed by its own clock, in busy seconds over threads.
#include "apps/bench/benchmarks.hpp"

#include <benchmark/benchmark.h>

#include "apps/bench/grains.hpp"
#include "apps/bench/laws.hpp"
#include "apps/bench/lists.hpp"
#include "runtime/phase/phases.hpp"

namespace talus::bench {

namespace {

void count_grains(benchmark::State& state, const runtime::EngineState& s) {
    state.counters["grains/s"] = benchmark::Counter(static_cast<double>(s.sub.n_owned), benchmark::Counter::kIsIterationInvariantRate);
}

/// @param make  () -> Scene
template <class Make>
void whole_step(benchmark::State& state, Make make) {
    const Scene scene = make();
    talus_engine* engine = scene.engine.get();
    constexpr std::int64_t kSteps = 50;
    check(talus_engine_step(engine, 0, nullptr), engine);
    const auto& s = engine->engine->state();
    const std::int64_t rebuilds = s.counters.rebuilds;
    for (auto _ : state) check(talus_engine_step(engine, kSteps, nullptr), engine);
    state.counters["grain-steps/s"] = benchmark::Counter(static_cast<double>(s.sub.n_owned * kSteps), benchmark::Counter::kIsIterationInvariantRate);
    state.counters["B/grain"] = static_cast<double>(s.sub.bytes().total()) / s.sub.n_owned;
    state.counters["skin/d"] = s.model.skin() / s.model.diameter();
    state.counters["steps/rebuild"] = static_cast<double>(state.iterations() * kSteps) / static_cast<double>(std::max<std::int64_t>(1, s.counters.rebuilds - rebuilds));
    const auto velocity = mean_velocity(gather(engine));
    state.counters["mean vx"] = velocity[0];
    state.counters["mean vy"] = velocity[1];
}

void force(benchmark::State& state, const SceneOptions& o, const NamedLaws& laws, core::KernelWidth width) {
    const Scene scene = make_bed(o, laws.laws());
    runtime::EngineState& s = scene.engine->engine->state();
    runtime::refresh_contexts(s);
    s.kernels = core::select_kernels(s.model.settings.laws, false, width);
    s.with_forces = true;
    const int tiles = static_cast<int>(s.sub.tiles.size());
    // Contacts do not change, since no grain moves.
    for (auto _ : state)
        s.workers.arena().execute([&] {
            for (int t = 0; t < tiles; ++t) runtime::force_tile(s, t);
        });
    count_grains(state, s);
    const ListCounts pairs = count_pairs(s);
    state.counters["pairs"] = pairs.candidates;
    state.counters["contacts"] = pairs.contacts;
}

void integrate(benchmark::State& state, const SceneOptions& o) {
    const Scene scene = make_bed(o, kLaws[0].laws());
    runtime::EngineState& s = scene.engine->engine->state();
    runtime::refresh_contexts(s);
    s.integrate.finish = s.integrate.begin = true;
    s.integrate.dt = 1e-30; // grains stay where the lists know them
    s.with_forces = true;
    for (auto _ : state)
        for (int t = 0; t < static_cast<int>(s.sub.tiles.size()); ++t) runtime::integrate_tile(s, t);
    count_grains(state, s);
}

/// One phase of a rebuild, by its own clock.
void rebuild(benchmark::State& state, const SceneOptions& o, runtime::Phase phase) {
    const Scene scene = make_bed(o, kLaws[0].laws());
    runtime::EngineState& s = scene.engine->engine->state();
    for (auto _ : state) {
        const double before = s.workers.total(phase).seconds;
        runtime::rebuild(s, false, false);
        state.SetIterationTime(s.workers.total(phase).seconds - before);
    }
    count_grains(state, s);
}

} // namespace

void add_benchmarks(const SceneOptions& o) {
    using benchmark::RegisterBenchmark;
    for (const NamedLaws& l : kLaws) RegisterBenchmark(fmt::format("step/{}", l.name).c_str(), [=](benchmark::State& st) { whole_step(st, [&] { return make_bed(o, l.laws()); }); })->UseRealTime();
    // Told how often: a chute takes long to set up, and a gas cools.
    RegisterBenchmark("step/chute", [=](benchmark::State& st) { whole_step(st, [&] { return make_chute(o); }); })->UseRealTime()->Iterations(10);
    RegisterBenchmark("step/gas", [=](benchmark::State& st) { whole_step(st, [&] { return make_gas(o); }); })->UseRealTime()->Iterations(6);
    for (const NamedLaws& l : kLaws) {
        for (const auto& [name, width] : {std::pair{"eight", core::KernelWidth::eight}, {"four", core::KernelWidth::four}, {"scalar", core::KernelWidth::scalar}})
            if (core::has_width(width)) RegisterBenchmark(fmt::format("force/{}/{}", l.name, name).c_str(), [=, width = width](benchmark::State& st) { force(st, o, l, width); });
    }
    RegisterBenchmark("integrate", [=](benchmark::State& st) { integrate(st, o); });
    for (const auto p : {runtime::Phase::binning, runtime::Phase::pair_build, runtime::Phase::halo_exchange, runtime::Phase::rebalance})
        RegisterBenchmark(runtime::phase_name(p), [=](benchmark::State& st) { rebuild(st, o, p); })->UseManualTime()->Iterations(20);
}

} // namespace talus::bench
