#include "apps/bench/table.hpp"

#include <algorithm>
#include <chrono>
#include <ctime>

#include "apps/bench/grains.hpp"
#include "apps/sandbox/process_memory.hpp"
#include "runtime/phase/phases.hpp"

namespace talus::bench {

namespace {

using Clock = std::chrono::steady_clock;
using runtime::EngineState;
using runtime::Phase;

/// Lists are looked at so many times during the steps: they change.
constexpr std::int64_t kLooks = 10;
/// Not fewer steps than this at a time: each call ends with half a firing of its own.
constexpr std::int64_t kLeastSteps = 50;
constexpr double kLoopSeconds = 1.0;
constexpr int kEmptyFirings = 300;

/// Of core/integrate.cpp, a free grain that ends one step and begins the next: force and torque in SI 6, factors of the kicks 5, two kicks of
/// 2 x 3 fused (12) and 3 for gravity, drift 3 fused, displacement 3, foresight 3 fused.
constexpr double kIntegrateFlops = 6.0 + 5.0 + 2.0 * (12.0 + 3.0) + 6.0 + 3.0 + 6.0;

constexpr Phase kPhases[] = {Phase::binning, Phase::pair_build, Phase::force, Phase::integrate, Phase::halo_exchange, Phase::rebalance};

template <class Body>
double seconds_of(Body body) {
    const auto from = Clock::now();
    body();
    return std::chrono::duration<double>(Clock::now() - from).count();
}

/// Of all threads of this process [s].
double processor_seconds() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// The steps themselves: wall and busy times, and means of what is in the lists.
void run_steps(talus_engine* engine, std::int64_t steps, Table& t, Traffic& a_step) {
    EngineState& s = engine->engine->state();
    const std::int64_t rebuilds = s.counters.rebuilds;
    std::vector<double> before;
    for (const Phase p : kPhases) before.push_back(s.workers.total(p).seconds);
    const double busy_before = s.workers.busy();
    const std::int64_t looks = std::clamp<std::int64_t>(steps / kLeastSteps, 1, kLooks);
    for (std::int64_t k = 0; k < looks; ++k) {
        const double processor = processor_seconds();
        t.wall += seconds_of([&] { check(talus_engine_step(engine, steps * (k + 1) / looks - steps * k / looks, nullptr), engine); });
        t.processor += processor_seconds() - processor;
        const ListCounts pairs = count_pairs(s), walls = count_walls(s);
        const double share = 1.0 / static_cast<double>(looks);
        t.candidates += share * (pairs.candidates + walls.candidates);
        t.contacts += share * pairs.contacts;
        t.wall_contacts += share * walls.contacts;
        const Traffic now = traffic(s);
        a_step.force += share * now.force;
        a_step.integrate += share * now.integrate;
        a_step.binning += share * now.binning;
        a_step.pair_build += share * now.pair_build;
    }
    t.rebuilds = s.counters.rebuilds - rebuilds;
    for (std::size_t k = 0; k < std::size(kPhases); ++k)
        t.phases.push_back({runtime::phase_name(kPhases[k]), (s.workers.total(kPhases[k]).seconds - before[k]) / t.particle_steps()});
    t.processor /= t.threads * t.wall;
    t.idle = 1.0 - (s.workers.busy() - busy_before) / (t.threads * t.wall);
    const double rebuilds_a_step = static_cast<double>(t.rebuilds) / static_cast<double>(t.steps);
    a_step.binning *= rebuilds_a_step;
    a_step.pair_build *= rebuilds_a_step;
}

PhaseRow& phase(Table& t, Phase p) {
    return *std::find_if(t.phases.begin(), t.phases.end(), [&](const PhaseRow& r) { return r.name == runtime::phase_name(p); });
}

void look_at_end(talus_engine* engine, Table& t) {
    talus_energy energy;
    check(talus_energy_init(&energy), engine);
    check(talus_engine_energy(engine, &energy), engine);
    t.kinetic_energy = energy.kinetic;
    const Grains grains = gather(engine);
    for (std::size_t k = 0; k < grains.count(); ++k) t.mean_height += grains.position[3 * k + 1] / t.particles;
    t.velocity = mean_velocity(grains);
    const EngineState& s = engine->engine->state();
    t.contacts_per_particle = 2.0 * count_pairs(s).contacts / t.particles;
}

/// Where grains stand, by turns: the graph fired for its forces alone, and its force tasks one after the other on one worker.
/// @return busy seconds of each, medians
std::pair<double, double> force_in_graph_and_loop(EngineState& s) {
    runtime::refresh_contexts(s);
    s.with_forces = true;
    s.integrate.finish = s.integrate.begin = false;
    const int tiles = static_cast<int>(s.sub.tiles.size());
    std::vector<double> graph, loop;
    const auto fire = [&] {
        const double before = s.workers.total(Phase::force).seconds;
        s.graph->fire();
        graph.push_back(s.workers.total(Phase::force).seconds - before);
    };
    const auto from = Clock::now();
    do {
        s.workers.arena().execute([&] { loop.push_back(seconds_of([&] { for (int t = 0; t < tiles; ++t) runtime::force_tile(s, t); })); });
        fire(); // last: border rows are collected by it
    } while (std::chrono::duration<double>(Clock::now() - from).count() < kLoopSeconds);
    const auto median = [](std::vector<double>& v) {
        std::nth_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2), v.end());
        return v[v.size() / 2];
    };
    return {median(graph), median(loop)};
}

double empty_firing(EngineState& s, int& nodes) {
    runtime::GraphShape shape = s.graph->shape();
    nodes = 2 * static_cast<int>(shape.neighbours.size());
    runtime::StepHooks hooks;
    hooks.force = hooks.integrate = hooks.send = [](int) {};
    hooks.halo_arrived = [] { return true; };
    hooks.halo_take = [](int) {};
    hooks.halo_taken = [] {};
    runtime::StepGraph graph(s.workers, std::move(shape), std::move(hooks));
    graph.fire();
    return seconds_of([&] { for (int k = 0; k < kEmptyFirings; ++k) graph.fire(); }) / kEmptyFirings;
}

} // namespace

double Table::divider_bound() const {
    Operations all = force.pairs;
    all += force.walls;
    return end_contacts() > 0.0 ? (all.divide * roofs.divide + all.root * roofs.root) / core::kLanes<core::V4> / end_contacts() : 0.0;
}

Table measure(Scene& scene, const std::string& name, const TableOptions& o) {
    talus_engine* engine = scene.engine.get();
    check(talus_engine_step(engine, o.warm, nullptr), engine);
    EngineState& s = engine->engine->state();
    Table t;
    t.scene = name;
    t.build = talus_build_info();
    t.laws = s.model.settings.laws;
    t.threads = s.workers.threads();
    t.steps = o.steps;
    t.particles = static_cast<double>(s.sub.n_owned);
    t.skin = s.model.skin();
    Traffic moved;
    forget_peak();
    run_steps(engine, o.steps, t, moved);
    t.memory = s.sub.bytes();
    t.resident = resident_bytes() - o.resident_before;
    t.peak = peak_bytes() - o.resident_before;
    look_at_end(engine, t);

    phase(t, Phase::binning).bytes = moved.binning / t.particles;
    phase(t, Phase::pair_build).bytes = moved.pair_build / t.particles;
    phase(t, Phase::integrate).bytes = moved.integrate / t.particles;
    phase(t, Phase::integrate).flops = kIntegrateFlops;
    PhaseRow& force = phase(t, Phase::force);
    force.bytes = moved.force / t.particles;
    t.law = count_law(t.laws);
    t.force = count_forces(s);
    t.end_pairs = count_pairs(s);
    t.end_walls = count_walls(s);
    const double contacts = t.contacts + t.wall_contacts;
    // Counted where lists stand at the end, brought to the mean number of contacts.
    if (t.end_contacts() > 0.0) force.flops = (t.force.pairs.flops() + t.force.walls.flops()) * contacts / t.end_contacts() / t.particles;

    if (contacts > 0.0) t.force_in_steps = force.busy * t.particles / contacts;
    if (t.end_contacts() > 0.0) {
        const auto [graph, loop] = force_in_graph_and_loop(s);
        t.force_in_graph = graph / t.end_contacts();
        t.force_in_loop = loop / t.end_contacts();
    }
    t.empty_firing = empty_firing(s, t.nodes);
    t.roofs = {triad_bandwidth(t.threads), divide_time(), root_time()};
    return t;
}

} // namespace talus::bench
