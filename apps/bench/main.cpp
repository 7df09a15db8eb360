// talus-bench: phase timings on a bed of sand, by Google Benchmark; counters in grains a second.
//
//   talus-bench [--bed FILE --axes xzy] [--grains N] [--threads T] [--skin M] [Google Benchmark's own options]
//
// Phases: binning, pair_build (with inheritance), force (each law at each width), integrate, halo_exchange and rebalance (which
// need ranks and cost nothing on one), and the whole step. One rank; a phase that runs on several threads is timed by its own
// clock, in busy seconds over threads.
#include <benchmark/benchmark.h>

#include <CLI/CLI.hpp>

#include "apps/bench/scene.hpp"
#include "runtime/phase/phases.hpp"

namespace talus::bench {

namespace {

struct NamedLaws {
    const char* name;
    std::int32_t normal, damping, tangential, rolling;
};
constexpr NamedLaws kLaws[] = {
    {"default", TALUS_NORMAL_HERTZ, TALUS_DAMPING_CLIPPED, TALUS_TANGENTIAL_FORCE_RESCALED, TALUS_ROLLING_CONSTANT},
    {"default_spring", TALUS_NORMAL_HERTZ, TALUS_DAMPING_CLIPPED, TALUS_TANGENTIAL_FORCE_RESCALED, TALUS_ROLLING_SPRING},
    {"displacement_spring_attractive", TALUS_NORMAL_HERTZ, TALUS_DAMPING_ATTRACTIVE, TALUS_TANGENTIAL_DISPLACEMENT, TALUS_ROLLING_SPRING},
    {"displacement_constant_attractive", TALUS_NORMAL_HERTZ, TALUS_DAMPING_ATTRACTIVE, TALUS_TANGENTIAL_DISPLACEMENT, TALUS_ROLLING_CONSTANT},
    {"displacement_attractive", TALUS_NORMAL_HERTZ, TALUS_DAMPING_ATTRACTIVE, TALUS_TANGENTIAL_DISPLACEMENT, TALUS_ROLLING_NONE},
    {"linear", TALUS_NORMAL_LINEAR, TALUS_DAMPING_CLIPPED, TALUS_TANGENTIAL_FORCE, TALUS_ROLLING_CONSTANT},
    {"frictionless", TALUS_NORMAL_HERTZ, TALUS_DAMPING_CLIPPED, TALUS_TANGENTIAL_NONE, TALUS_ROLLING_NONE},
};

talus_laws laws_of(const NamedLaws& n) {
    talus_laws l;
    talus_laws_init(&l);
    l.normal = n.normal;
    l.damping = n.damping;
    l.tangential = n.tangential;
    l.rolling = n.rolling;
    l.stiffness_n = 1e3;
    return l;
}

void count_grains(benchmark::State& state, const runtime::EngineState& s) {
    state.counters["grains/s"] = benchmark::Counter(static_cast<double>(s.sub.n_owned), benchmark::Counter::kIsIterationInvariantRate);
}

void whole_step(benchmark::State& state, const SceneOptions& o, const NamedLaws& laws) {
    const EnginePtr engine = make_bed(o, laws_of(laws));
    constexpr std::int64_t kSteps = 50;
    const auto& s = engine->engine->state();
    const std::int64_t steps_before = s.model.step, rebuilds_before = s.counters.rebuilds;
    for (auto _ : state) check(talus_engine_step(engine.get(), kSteps, nullptr), engine.get());
    state.counters["skin/d"] = s.model.skin() / s.model.diameter();
    state.counters["rebuilds/step"] = static_cast<double>(s.counters.rebuilds - rebuilds_before) / static_cast<double>(s.model.step - steps_before);
    state.counters["grain-steps/s"] = benchmark::Counter(static_cast<double>(s.sub.n_owned * kSteps), benchmark::Counter::kIsIterationInvariantRate);
    state.counters["B/grain"] = static_cast<double>(s.sub.bytes()) / s.sub.n_owned;
}

void force(benchmark::State& state, const SceneOptions& o, const NamedLaws& laws, core::KernelWidth width) {
    const EnginePtr engine = make_bed(o, laws_of(laws));
    runtime::EngineState& s = engine->engine->state();
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
    double pairs = 0.0, contacts = 0.0;
    for (const core::Tile& tile : s.sub.tiles) {
        pairs += tile.pairs.n_contacts + tile.pairs.n_candidates;
        for (std::uint32_t k = 0; k < tile.pairs.n_contacts; ++k) contacts += tile.pairs.touches(k) ? 1.0 : 0.0;
    }
    state.counters["pairs"] = pairs;
    state.counters["contacts"] = contacts;
}

void integrate(benchmark::State& state, const SceneOptions& o) {
    const EnginePtr engine = make_bed(o, laws_of(kLaws[0]));
    runtime::EngineState& s = engine->engine->state();
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
    const EnginePtr engine = make_bed(o, laws_of(kLaws[0]));
    runtime::EngineState& s = engine->engine->state();
    for (auto _ : state) {
        const double before = s.workers.total(phase).seconds;
        runtime::rebuild(s, false);
        state.SetIterationTime(s.workers.total(phase).seconds - before);
    }
    count_grains(state, s);
}

void add_benchmarks(const SceneOptions& o) {
    using benchmark::RegisterBenchmark;
    for (const NamedLaws& l : kLaws) RegisterBenchmark(fmt::format("step/{}", l.name).c_str(), [=](benchmark::State& st) { whole_step(st, o, l); })->UseRealTime();
    for (const NamedLaws& l : kLaws) {
        for (const auto& [name, width] : {std::pair{"eight", core::KernelWidth::eight}, {"four", core::KernelWidth::four}, {"scalar", core::KernelWidth::scalar}})
            if (core::has_width(width)) RegisterBenchmark(fmt::format("force/{}/{}", l.name, name).c_str(), [=](benchmark::State& st) { force(st, o, l, width); });
    }
    RegisterBenchmark("integrate", [=](benchmark::State& st) { integrate(st, o); });
    for (const auto p : {runtime::Phase::binning, runtime::Phase::pair_build, runtime::Phase::halo_exchange, runtime::Phase::rebalance})
        RegisterBenchmark(runtime::phase_name(p), [=](benchmark::State& st) { rebuild(st, o, p); })->UseManualTime()->Iterations(20);
}

} // namespace

} // namespace talus::bench

int main(int argc, char** argv) {
    talus::bench::SceneOptions options;
    CLI::App app{"Phase timings of Talus; further options go to Google Benchmark (--benchmark_filter=..., --benchmark_format=json)."};
    app.add_option("--bed", options.bed, "bed file, text or HDF5; without it a bed is settled first")->check(CLI::ExistingFile);
    app.add_option("--axes", options.axes, "which axes of the file are our x, y (up), z")->capture_default_str();
    app.add_option("--grains", options.grains, "grains of the settled bed")->capture_default_str()->check(CLI::PositiveNumber);
    app.add_option("--threads", options.threads, "worker threads")->capture_default_str()->check(CLI::PositiveNumber);
    app.add_option("--skin", options.skin, "list skin [m]; 0 chooses")->capture_default_str();
    app.allow_extras();
    CLI11_PARSE(app, argc, argv);

    std::vector<std::string> rest = app.remaining();
    std::vector<char*> arguments{argv[0]};
    for (std::string& r : rest) arguments.push_back(r.data());
    int count = static_cast<int>(arguments.size());
    benchmark::Initialize(&count, arguments.data());
    if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 2;
    try {
        talus::bench::add_benchmarks(options);
        benchmark::RunSpecifiedBenchmarks();
    } catch (const std::exception& e) {
        std::fprintf(stderr, "talus-bench: %s\n", e.what());
        return 1;
    }
    return 0;
}
