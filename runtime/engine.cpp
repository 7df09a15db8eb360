// Life cycle and preparation: what must hold before a step.
#include "runtime/engine.hpp"

#include <cmath>
#include <fstream>

#include "core/packing.hpp"
#include "runtime/io/checkpoint.hpp"
#include "runtime/io/snapshot.hpp"
#include "runtime/phase/phases.hpp"

namespace talus::runtime {

using core::ErrorKind;
using core::fail;
using core::LocalIndex;
using core::Particle;

Engine::Engine(const Settings& settings, std::unique_ptr<Communicator> comm) {
    if (const std::string faults = settings_faults(settings, comm->size()); !faults.empty()) fail(ErrorKind::argument, "{}", faults);
    state_ = std::make_unique<EngineState>(settings, std::move(comm));
    choose_slices(*state_);
}

Engine::~Engine() = default;

std::unique_ptr<Engine> Engine::load(const std::string& path, const Settings& settings, std::unique_ptr<Communicator> comm) {
    Settings placeholder = settings; // physics comes from the file; only what is not physics must be right here
    for (int a = 0; a < 3; ++a) {
        placeholder.domain.lo[a] = 0.0;
        placeholder.domain.hi[a] = 1.0;
    }
    placeholder.time_step = 1.0;
    auto engine = std::make_unique<Engine>(placeholder, std::move(comm));
    EngineState& s = *engine->state_;
    load_checkpoint(s, path);
    s.sub.laid_out = true;
    engine->lists_stale_ = true;
    engine->setup_stale_ = false;
    engine->forces_stale_ = false;
    engine->prepare();
    return engine;
}

void Engine::require_healthy() const {
    if (poisoned_) fail(ErrorKind::state, "the engine stopped on an error before ({}); only messages and destroy still work. Load a checkpoint into a new engine to go on", state_->errors.message().empty() ? std::string("see the first message") : state_->errors.message());
}

void Engine::fix_units() {
    Model& m = state_->model;
    if (m.settings.radius_max > 0.0) m.radius_max = std::max(m.radius_max, m.settings.radius_max);
    double force_cap = 0.0;
    if (m.settings.laws.normal == core::NormalLaw::linear) {
        force_cap = m.settings.laws.stiffness_n * m.radius_max;
    } else {
        // The Hertz force of the stiffest pair at an overlap of the largest radius, against a wall.
        for (std::size_t a = 0; a < m.materials.size(); ++a)
            for (std::size_t b = a; b < m.materials.size(); ++b)
                if (!(m.materials[a].rigid && m.materials[b].rigid))
                    force_cap = std::max(force_cap, 4.0 / 3.0 * core::effective_young(m.materials[a], m.materials[b]) * m.radius_max * m.radius_max);
    }
    m.units = core::FixedUnits::make(force_cap, m.radius_max, m.settings.domain.extent());
    // As many small grains as fit around the largest one, each at the cap, must not overflow a sum.
    const double ratio = m.radius_max / m.radius_min;
    const double most_contacts = 4.0 * (1.0 + ratio) * (1.0 + ratio) + core::kMaxWalls;
    if (most_contacts > core::kMaxContributions)
        fail(ErrorKind::capacity, "radii from {} to {} m: the largest grain could have {:.0f} contacts, and force sums hold {}; a size ratio up to 44 is possible", m.radius_min, m.radius_max, most_contacts, core::kMaxContributions);
    m.units_fixed = true;
}

void Engine::derive_parameters() {
    EngineState& s = *state_;
    const Model& m = s.model;
    const int n = static_cast<int>(m.materials.size());
    if (s.comm->rank() == 0)
        for (int a = 0; a < n; ++a)
            for (int b = 0; b < n; ++b)
                if (m.contacts[a][b].is_set && !(m.materials[a].rigid && m.materials[b].rigid))
                    s.force.pairs[a][b] = core::derive_parameters(m.materials[a], m.materials[b], m.contacts[a][b], m.settings.laws);
    s.comm->broadcast(s.force.pairs, sizeof s.force.pairs, 0);
}

void Engine::check_setup() {
    EngineState& s = *state_;
    const Model& m = s.model;
    // Materials in use, over all ranks.
    std::vector<double> used(core::kMaxMaterials, 0.0);
    for (LocalIndex i = 0; i < s.sub.n_owned; ++i) used[core::material_of(s.sub.particles[i])] = 1.0;
    s.comm->max(used);
    const int n = static_cast<int>(m.materials.size());
    for (int a = 0; a < n; ++a) {
        if (used[a] == 0.0) continue;
        if (m.materials[a].rigid) fail(ErrorKind::argument, "material {} is rigid but grains are made of it; rigid is for walls", a);
        for (int b = 0; b < n; ++b)
            if (used[b] > 0.0 && b >= a && !m.contacts[a][b].is_set) fail(ErrorKind::argument, "materials {} and {} can meet but talus_contact_set was not called for them", a, b);
        for (std::size_t w = 0; w < m.walls.size(); ++w)
            if (!m.contacts[a][m.walls[w].plane.material].is_set) fail(ErrorKind::argument, "grains of material {} can meet wall {} (material {}) but talus_contact_set was not called for them", a, w, m.walls[w].plane.material);
    }
    const double critical = critical_step(), dt = m.settings.time_step;
    if (!(dt <= m.settings.time_step_limit * critical))
        fail(ErrorKind::argument, "time_step = {} s is {:.3g} of the critical step {} s of the present grains; the limit is {} of it (settings.time_step_limit), and 0.1 to 0.2 is usual", dt, dt / critical, critical, m.settings.time_step_limit);
}

double Engine::critical_step() {
    EngineState& s = *state_;
    const Model& m = s.model;
    double least = HUGE_VAL;
    agree(*s.comm, [&] {
        for (LocalIndex i = 0; i < s.sub.n_owned; ++i) {
            const Particle& p = s.sub.particles[i];
            const core::Material& mat = m.materials.at(static_cast<std::size_t>(core::material_of(p)));
            if (mat.rigid) continue;
            // The linear law's stiffness is the user's own: there the duration of a contact plays the Rayleigh step's part.
            const double step = m.settings.laws.normal == core::NormalLaw::linear ? core::kPi * std::sqrt(0.5 * p.mass / m.settings.laws.stiffness_n) : core::rayleigh_step(mat, p.radius);
            least = std::min(least, step);
        }
    });
    return s.comm->min(least);
}

void Engine::refresh_lists() {
    EngineState& s = *state_;
    const core::Domain& d = s.model.settings.domain;
    const double reach = s.model.required_reach();
    if (!sliced_) choose_slices(s);
    for (int a = 0; a < 3; ++a) {
        if (d.periodic[a] && d.length(a) < 2.0 * reach)
            fail(ErrorKind::argument, "the periodic length along {} is {} m, below 2 (d_max + skin) = {} m: a grain would meet the same partner twice. Make the domain longer, the skin smaller, or the axis closed", "xyz"[a], d.length(a), 2.0 * reach);
        if (s.slices.grid()[a] > 1 && d.length(a) / s.slices.grid()[a] < reach)
            fail(ErrorKind::argument, "{} subdomains along {} would be {} m wide, less than the halo of {} m (d_max + skin): use fewer ranks, or cut another axis (settings.rank_grid)", s.slices.grid()[a], "xyz"[a], d.length(a) / s.slices.grid()[a], reach);
    }
    s.watch.disturbed = true;
    try {
        rebuild(s, !sliced_, true);
    } catch (...) {
        poisoned_ = true; // half of the histories may be in new lists
        throw;
    }
    rebuild_due_ = ghosts_behind_ = false;
    lists_stale_ = false;
    verdict_stale_ = true;
}

/// Grains may move farther in the next step than the lists foresee. That is no worse with a skin that has become narrow at rest
/// than with the first one.
void Engine::expect_motion() {
    const Model& m = state_->model;
    verdict_stale_ = true;
    lists_stale_ = lists_stale_ || (m.automatic_skin() && m.skin_share < core::kFirstSkin);
}

/// What the ranks were told must be the same, bit for bit; and what one of them knows to be stale is stale for all.
void Engine::agree_on_input() {
    EngineState& s = *state_;
    if (!s.parallel()) return;
    bool* const flags[] = {&lists_stale_, &setup_stale_, &forces_stale_, &verdict_stale_};
    std::vector<double> v;
    for (const bool* flag : flags) v.push_back(*flag ? 1.0 : 0.0);
    for (const std::uint64_t print : fingerprints(s.model)) {
        const auto exact = static_cast<double>(print >> 12); // below 2^52
        v.push_back(exact);
        v.push_back(-exact);
    }
    s.comm->max(v);
    std::size_t k = 0;
    for (bool* flag : flags) *flag = v[k++] > 0.0;
    for (const char* part : kModelParts) {
        const double most = v[k++], least = -v[k++];
        if (most != least) fail(ErrorKind::argument, "{}: the values differ between ranks; every rank must give the same, to the bit", part);
    }
}

void Engine::prepare() {
    require_healthy();
    EngineState& s = *state_;
    agree_on_input();
    if (!lists_stale_ && !setup_stale_ && !forces_stale_) return;
    finish_step();
    if (s.model.n_particles == 0) fail(ErrorKind::state, "there are no grains: insert some before the first step");
    if (setup_stale_ || lists_stale_) check_setup();
    if (!s.model.units_fixed) fix_units();
    if (setup_stale_) derive_parameters();
    setup_stale_ = false;
    if (lists_stale_ || !s.graph) refresh_lists();
    if (forces_stale_) first_forces();
    forces_stale_ = false;
    sliced_ = true; // grains that come before the first step may still change how they are shared out
    refresh_contexts(s);
    ++generation_;
}

void Engine::prepare_contacts() {
    prepare();
    if (!ghosts_behind_) return;
    finish_step();
    EngineState& s = *state_;
    s.workers.timed(Phase::halo_exchange, 0, [&] { s.halo.refresh(s.sub); });
    ghosts_behind_ = false;
}

void Engine::fold_wall_work() {
    EngineState& s = *state_;
    if (s.sub.wall_impulse.empty()) return;
    for (std::size_t w = 0; w < s.model.walls.size(); ++w) s.model.walls[w].work = wall_work(static_cast<int>(w));
    std::fill(s.sub.wall_impulse.begin(), s.sub.wall_impulse.end(), core::Wide{0});
}

double Engine::wall_work(int wall) {
    EngineState& s = *state_;
    const Wall& w = s.model.walls[static_cast<std::size_t>(wall)];
    if (s.sub.wall_impulse.empty()) return w.work;
    core::Wide sum[3];
    for (int c = 0; c < 3; ++c) sum[c] = s.sub.wall_impulse[3 * static_cast<std::size_t>(wall) + c];
    s.comm->sum(sum, 3);
    const double v[3] = {w.plane.velocity.x, w.plane.velocity.y, w.plane.velocity.z};
    double power = 0.0;
    for (int c = 0; c < 3; ++c) power -= core::to_double(sum[c], s.model.units.force.unit) * v[c];
    return w.work + power * s.model.settings.time_step;
}

std::unique_ptr<KeptState> Engine::keep() {
    prepare();
    finish_step();
    std::unique_ptr<KeptState> kept;
    agree(*state_->comm, [&] { kept = std::make_unique<KeptState>(*state_); });
    return kept;
}

void Engine::restore(const KeptState& kept) {
    require_healthy();
    try {
        agree(*state_->comm, [&] { kept.restore(*state_); });
    } catch (...) {
        poisoned_ = true;
        throw;
    }
    lists_stale_ = true;
    setup_stale_ = forces_stale_ = sliced_ = rebuild_due_ = kick_due_ = ghosts_behind_ = false;
    ++generation_;
}

void Engine::save(const std::string& path) {
    prepare();
    save_checkpoint(*state_, path);
}

void Engine::snapshot(const std::string& path) {
    prepare();
    write_snapshot(*state_, path);
}

void Engine::start_trace(const std::string& path, std::int64_t steps) {
    if (steps < 1) fail(ErrorKind::argument, "trace steps = {}: must be >= 1", steps);
    trace_path_ = path;
    trace_left_ = steps;
    state_->workers.start_trace();
}

void Engine::write_trace() {
    EngineState& s = *state_;
    const std::string mine = s.workers.stop_trace(s.comm->rank());
    Bytes bytes(mine.size());
    std::memcpy(bytes.data(), mine.data(), mine.size());
    const std::vector<Bytes> all = s.comm->gather(bytes);
    agree(*s.comm, [&] {
        if (s.comm->rank() != 0) return;
        std::ofstream out(trace_path_, std::ios::binary);
        out << "{\"displayTimeUnit\":\"ns\",\"traceEvents\":[\n";
        for (std::size_t r = 0; r < all.size(); ++r) {
            if (r > 0) out << ",\n";
            out.write(reinterpret_cast<const char*>(all[r].data()), static_cast<std::streamsize>(all[r].size()));
        }
        out << "\n]}\n";
        out.close();
        if (!out) fail(ErrorKind::io, "{}: the trace could not be written", trace_path_);
    });
}

} // namespace talus::runtime
