// Stepping, observing, files.
#include <array>

#include "capi/src/guard.hpp"
#include "runtime/phase/observe.hpp"

using namespace talus;
using namespace talus::capi;

namespace {

double share_of_bytes(const runtime::EngineState& s) {
    const auto bytes = static_cast<double>(s.sub.bytes().total());
    return bytes / std::max<double>(1.0, s.sub.n_owned);
}

} // namespace

/// @param steps_of  (engine) how many
template <class StepsOf>
static talus_status step_engine(talus_engine* engine, int64_t* out_done, StepsOf steps_of) {
    bool stopped = false;
    const talus_status status = with_engine<LastStep::as_it_is>(engine, [&](runtime::Engine& e) {
        std::int64_t done = 0;
        try {
            stopped = e.step(steps_of(e), done);
        } catch (...) {
            if (out_done != nullptr) *out_done = done;
            throw;
        }
        if (out_done != nullptr) *out_done = done;
    });
    return status == TALUS_OK && stopped ? TALUS_STOPPED : status;
}

extern "C" {

talus_status talus_engine_step(talus_engine* engine, int64_t n_steps, int64_t* out_done) {
    return step_engine(engine, out_done, [&](runtime::Engine&) { return n_steps; });
}

talus_status talus_engine_advance_to(talus_engine* engine, double time, int64_t* out_done) {
    return step_engine(engine, out_done, [&](runtime::Engine& e) { return e.steps_until(time); });
}

void talus_engine_request_stop(talus_engine* engine) {
    if (engine != nullptr && engine->live == talus_engine::kLive) engine->engine->request_stop();
}

// The name itself is called by programs of the first header, which have room for no more.
talus_status(talus_state_init)(talus_state* out) { return init_struct(out, talus_state{}, offsetof(talus_state, halo_messages)); }
talus_status talus_state_init_sized(talus_state* out, size_t struct_size) { return init_struct(out, talus_state{}, struct_size); }

talus_status talus_engine_state(talus_engine* engine, talus_state* out_state) {
    return with_engine(engine, [&](runtime::Engine& e) {
        require_on_all(e, out_state, "out_state");
        runtime::EngineState& s = e.state();
        talus_state t{};
        t.threads = s.workers.threads();
        t.threads_observed = static_cast<int32_t>(s.comm->min(static_cast<double>(s.workers.observed())));
        t.ranks = s.comm->size();
        t.step = s.model.step;
        t.time = s.model.time;
        t.particles = s.model.n_particles;
        t.local_particles = s.sub.n_owned;
        t.ghosts = s.sub.n_ghosts();
        t.rebuilds = s.counters.rebuilds;
        t.rebalances = s.counters.rebalances;
        t.migrations = s.comm->sum(s.counters.migrations);
        t.imbalance = s.counters.imbalance;
        t.skin = s.model.skin();
        t.bytes_per_particle = s.comm->max(share_of_bytes(s));
        t.halo_messages = s.comm->sum(static_cast<std::int64_t>(s.halo.n_neighbours()));
        t.halo_bytes = s.comm->sum(s.halo.bytes_per_step());
        // Counts are all that a poisoned or empty engine can tell.
        if (!e.poisoned() && s.model.n_particles > 0) {
            e.prepare_contacts();
            const runtime::Observation o = runtime::observe(s);
            t.contacts = o.contacts;
            t.wall_contacts = o.wall_contacts;
            t.sliding_contacts = o.sliding;
            t.kinetic_energy = o.kinetic + o.rotational;
            t.max_speed = o.max_speed;
            t.unbalanced_force = o.unbalanced;
            t.max_overlap = o.max_overlap;
            const core::Digest d = runtime::digest(s);
            t.digest_lo = d.lo;
            t.digest_hi = d.hi;
        }
        write_struct(out_state, "out_state", t);
    });
}

talus_status talus_engine_ranks(talus_engine* engine, int32_t* io_count, talus_rank* out_ranks) {
    return with_engine<LastStep::as_it_is>(engine, [&](runtime::Engine& e) {
        runtime::EngineState& s = e.state();
        const int32_t n = s.comm->size();
        std::size_t size = 0;
        runtime::agree(*s.comm, [&] {
            require(io_count, "io_count");
            size = size_of_struct(out_ranks, "out_ranks");
            if (*io_count < n) {
                const int32_t given = *io_count;
                *io_count = n;
                core::fail(core::ErrorKind::argument, "*io_count = {}: there are {} ranks", given, n);
            }
        });
        talus_rank mine{};
        mine.rank = s.comm->rank();
        const core::Box box = s.slices.box(mine.rank);
        for (int a = 0; a < 3; ++a) {
            mine.lo[a] = std::max(box.lo[a], s.model.settings.domain.lo[a]);
            mine.hi[a] = std::min(box.hi[a], s.model.settings.domain.hi[a]);
        }
        mine.particles = s.sub.n_owned;
        mine.ghosts = s.sub.n_ghosts();
        mine.halo_messages = s.halo.n_neighbours();
        mine.halo_bytes = s.halo.bytes_per_step();
        mine.tiles = static_cast<int32_t>(s.sub.tiles.size());
        mine.threads = s.workers.threads();
        const auto steps = static_cast<double>(s.model.step - s.watch.built_step);
        mine.busy = steps > 0.0 ? s.load.busy_since(s.workers) / steps : 0.0;
        std::vector<talus_rank> all(static_cast<std::size_t>(n));
        s.comm->gather_all(&mine, sizeof mine, all.data());
        write_items(out_ranks, size, std::span<const talus_rank>(all));
        *io_count = n;
    });
}

talus_status talus_energy_init(talus_energy* out) { return init_struct(out, talus_energy{}); }

talus_status talus_engine_energy(talus_engine* engine, talus_energy* out_energy) {
    return with_engine(engine, [&](runtime::Engine& e) {
        require_on_all(e, out_energy, "out_energy");
        e.prepare_contacts();
        const runtime::Observation o = runtime::observe(e.state());
        talus_energy t{};
        t.kinetic = o.kinetic;
        t.rotational = o.rotational;
        t.elastic_normal = o.elastic_normal;
        t.elastic_tangential = o.elastic_tangential;
        t.elastic_rolling = o.elastic_rolling;
        t.gravity = o.gravity;
        for (std::size_t w = 0; w < e.state().model.walls.size(); ++w) t.wall_work += e.wall_work(static_cast<int>(w));
        t.friction = o.friction;
        t.damping = o.damping;
        t.rolling = o.rolling;
        write_struct(out_energy, "out_energy", t);
    });
}

talus_status talus_engine_stress(talus_engine* engine, const double lo[3], const double hi[3], double out_stress[9], double* out_solid_fraction, double* out_coordination) {
    return with_engine(engine, [&](runtime::Engine& e) {
        double from[3], to[3];
        runtime::agree(*e.state().comm, [&] {
            read_box(lo, hi, from, to);
            require(out_stress, "out_stress");
        });
        e.prepare_contacts();
        const runtime::StressObservation o = runtime::observe_stress(e.state(), from, to);
        for (int k = 0; k < 9; ++k) out_stress[k] = o.stress[k];
        if (out_solid_fraction != nullptr) *out_solid_fraction = o.solid_fraction;
        if (out_coordination != nullptr) *out_coordination = o.coordination;
    });
}

talus_status talus_engine_internal_force_sum(talus_engine* engine, int64_t out_sum[3], double* out_unit) {
    return with_engine(engine, [&](runtime::Engine& e) {
        require_on_all(e, out_sum, "out_sum");
        e.prepare();
        std::int64_t sum[3];
        runtime::internal_force_sum(e.state(), sum);
        for (int c = 0; c < 3; ++c) out_sum[c] = sum[c];
        if (out_unit != nullptr) *out_unit = e.state().model.units.force.unit;
    });
}

talus_status talus_phase_init(talus_phase* out) { return init_struct(out, talus_phase{}); }
talus_status talus_rank_init(talus_rank* out) { return init_struct(out, talus_rank{}); }

talus_status talus_engine_phases(talus_engine* engine, int32_t* io_count, talus_phase* out_phases) {
    return with_engine<LastStep::as_it_is>(engine, [&](runtime::Engine& e) {
        std::size_t size = 0;
        runtime::agree(*e.state().comm, [&] {
            require(io_count, "io_count");
            size = size_of_struct(out_phases, "out_phases");
            if (*io_count < runtime::kPhases) {
                const int32_t given = *io_count;
                *io_count = runtime::kPhases;
                core::fail(core::ErrorKind::argument, "*io_count = {}: there are {} phases", given, runtime::kPhases);
            }
        });
        *io_count = runtime::kPhases;
        runtime::Communicator& comm = *e.state().comm;
        std::array<talus_phase, runtime::kPhases> all{};
        for (int p = 0; p < runtime::kPhases; ++p) {
            const auto mine = e.state().workers.total(static_cast<runtime::Phase>(p));
            talus_phase& t = all[static_cast<std::size_t>(p)];
            std::strncpy(t.name, runtime::phase_name(static_cast<runtime::Phase>(p)), sizeof t.name - 1);
            t.min = comm.min(mine.seconds);
            t.max = comm.max(mine.seconds);
            t.mean = static_cast<double>(comm.sum(static_cast<std::int64_t>(mine.seconds * 1e9))) * 1e-9 / comm.size();
            t.calls = mine.calls;
        }
        write_items(out_phases, size, std::span<const talus_phase>(all));
    });
}

talus_status talus_memory_init(talus_memory* out) { return init_struct(out, talus_memory{}); }

talus_status talus_engine_memory(talus_engine* engine, talus_memory* out_memory) {
    return with_engine<LastStep::as_it_is>(engine, [&](runtime::Engine& e) {
        const runtime::Subdomain::Bytes b = e.state().sub.bytes();
        talus_memory t{};
        const auto bytes = [](std::size_t n) { return static_cast<int64_t>(n); };
        t.records = bytes(b.records);
        t.cells = bytes(b.cells);
        t.sums = bytes(b.sums);
        t.pairs = bytes(b.pairs);
        t.histories = bytes(b.histories);
        t.rebuild = bytes(b.rebuild);
        write_struct(out_memory, "out_memory", t);
    });
}

talus_status talus_checkpoint_save(talus_engine* engine, const char* path) {
    return with_engine(engine, [&](runtime::Engine& e) {
        require_on_all(e, path, "path");
        e.save(path);
    });
}

talus_status talus_engine_keep(talus_engine* engine, talus_kept** out_kept) {
    return with_engine(engine, [&](runtime::Engine& e) {
        require_on_all(e, out_kept, "out_kept");
        std::unique_ptr<talus_kept> kept;
        runtime::agree(*e.state().comm, [&] { kept = std::make_unique<talus_kept>(); });
        kept->of = engine->self;
        kept->state = e.keep();
        *out_kept = kept.release();
    });
}

talus_status talus_engine_restore(talus_engine* engine, const talus_kept* kept) {
    return with_engine<LastStep::as_it_is>(engine, [&](runtime::Engine& e) {
        runtime::agree(*e.state().comm, [&] {
            require(kept, "kept");
            if (kept->live != talus_kept::kLive || kept->of.lock() != engine->self) core::fail(core::ErrorKind::argument, "the kept state is not one of this engine");
        });
        e.restore(*kept->state);
    });
}

void talus_kept_destroy(talus_kept* kept) {
    if (kept == nullptr || kept->live != talus_kept::kLive) return;
    kept->live = 0;
    delete kept;
}

talus_status talus_snapshot_write(talus_engine* engine, const char* path) {
    return with_engine(engine, [&](runtime::Engine& e) {
        require_on_all(e, path, "path");
        e.snapshot(path);
    });
}

talus_status talus_trace_start(talus_engine* engine, const char* path, int64_t steps) {
    return with_engine(engine, [&](runtime::Engine& e) {
        require_on_all(e, path, "path");
        e.start_trace(path, steps);
    });
}

} // extern "C"
