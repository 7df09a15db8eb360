// Status, versions, settings, and the making and unmaking of engines.
#include <array>
#include <cmath>
#include <limits>

#include "capi/src/guard.hpp"
#include "core/slice_grid.hpp"

#ifndef TALUS_BUILD_COMPILER
#define TALUS_BUILD_COMPILER __VERSION__
#endif
#ifndef TALUS_BUILD_TYPE
#define TALUS_BUILD_TYPE "unknown build type"
#endif

namespace talus::capi {

std::string& thread_message() {
    static thread_local std::string message;
    return message;
}

namespace {

talus_laws default_laws() {
    const core::Laws d;
    talus_laws l{};
    l.struct_size = sizeof l;
    l.tangential_damping = d.tangential_damping ? 1 : 0;
    l.normal = static_cast<int32_t>(d.normal);
    l.damping = static_cast<int32_t>(d.damping);
    l.tangential = static_cast<int32_t>(d.tangential);
    l.rolling = static_cast<int32_t>(d.rolling);
    l.rolling_radius = static_cast<int32_t>(d.rolling_radius);
    l.rolling_rate = d.rolling_rate;
    l.rolling_damping = d.rolling_damping;
    return l;
}

talus_settings default_settings() {
    const runtime::Settings d;
    const double nan = std::numeric_limits<double>::quiet_NaN();
    talus_settings s{};
    s.struct_size = sizeof s;
    s.header_version = TALUS_VERSION_NUMBER;
    for (int a = 0; a < 3; ++a) {
        s.domain_lo[a] = s.domain_hi[a] = nan;
        s.gravity[a] = d.gravity[a];
    }
    s.threads = d.threads;
    s.time_step = nan;
    s.time_step_limit = d.time_step_limit;
    s.rebalance = static_cast<int32_t>(d.rebalance);
    s.rebalance_interval = d.rebalance_interval;
    s.seed = d.seed;
    s.laws = default_laws();
    return s;
}

runtime::Settings to_settings(const talus_settings* from) {
    const talus_settings c = read_struct(from, "settings", default_settings());
    if (c.header_version / 10000 != TALUS_VERSION_MAJOR)
        core::fail(core::ErrorKind::argument, "settings.header_version = {}: the program was compiled against another major version than this library ({}), or talus_settings_init was not called", c.header_version, TALUS_VERSION_NUMBER);
    runtime::Settings s;
    for (int a = 0; a < 3; ++a) {
        s.domain.lo[a] = c.domain_lo[a];
        s.domain.hi[a] = c.domain_hi[a];
        if (c.periodic[a] != 0 && c.periodic[a] != 1) core::fail(core::ErrorKind::argument, "settings.periodic[{}] = {}: must be 0 or 1", a, c.periodic[a]);
        s.domain.periodic[a] = c.periodic[a] != 0;
        s.gravity[a] = c.gravity[a];
        s.rank_grid[static_cast<std::size_t>(a)] = c.rank_grid[a];
    }
    s.threads = c.threads;
    s.time_step = c.time_step;
    s.time_step_limit = c.time_step_limit;
    s.skin = c.skin;
    s.radius_max = c.radius_max;
    s.tile_grains = c.tile_grains;
    s.rebalance = static_cast<runtime::Rebalance>(c.rebalance);
    s.rebalance_interval = c.rebalance_interval;
    s.energy_ledger = c.energy_ledger != 0;
    s.seed = c.seed;
    s.laws = to_laws(c.laws);
    return s;
}

void require_cpu() {
    if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma"))
        core::fail(core::ErrorKind::unsupported, "this processor lacks AVX2 or FMA, which Talus needs for results that are the same everywhere");
}

template <class Make>
talus_status create(talus_engine** out_engine, Make make) noexcept {
    return guarded(thread_message(), [&]() -> talus_status {
        auto handle = std::make_unique<talus_engine>();
        handle->engine = make();
        *out_engine = handle.release();
        return TALUS_OK;
    });
}

std::unique_ptr<runtime::Communicator> communicator(int32_t comm_f) {
    return comm_f == TALUS_SERIAL ? std::make_unique<runtime::Communicator>() : std::make_unique<runtime::Communicator>(comm_f);
}

/// Settings differ in NULL-ness and sizes between ranks only by mistake; a fault on one rank must be a fault on all.
std::unique_ptr<runtime::Engine> make_engine(const talus_settings* settings, std::unique_ptr<runtime::Communicator> comm, talus_engine** out_engine) {
    runtime::Settings s;
    runtime::agree(*comm, [&] {
        require(out_engine, "out_engine");
        require_cpu();
        s = to_settings(settings);
    });
    return std::make_unique<runtime::Engine>(s, std::move(comm));
}

} // namespace

core::Laws to_laws(const talus_laws& from) {
    const talus_laws c = read_struct(&from, "laws", default_laws());
    core::Laws l;
    l.normal = static_cast<core::NormalLaw>(c.normal);
    l.damping = static_cast<core::Damping>(c.damping);
    l.tangential = static_cast<core::TangentialLaw>(c.tangential);
    l.rolling = static_cast<core::RollingLaw>(c.rolling);
    l.rolling_radius = static_cast<core::RollingRadius>(c.rolling_radius);
    l.tangential_damping = c.tangential_damping != 0;
    l.rolling_rate = c.rolling_rate;
    l.rolling_damping = c.rolling_damping;
    l.stiffness_n = c.stiffness_n;
    l.stiffness_t = c.stiffness_t;
    return l;
}

} // namespace talus::capi

using namespace talus;
using namespace talus::capi;

extern "C" {

const char* talus_status_string(talus_status status) {
    switch (status) {
    case TALUS_OK: return "TALUS_OK";
    case TALUS_STOPPED: return "TALUS_STOPPED";
    case TALUS_ERR_ARGUMENT: return "TALUS_ERR_ARGUMENT";
    case TALUS_ERR_STATE: return "TALUS_ERR_STATE";
    case TALUS_ERR_UNSTABLE: return "TALUS_ERR_UNSTABLE";
    case TALUS_ERR_LOST: return "TALUS_ERR_LOST";
    case TALUS_ERR_IO: return "TALUS_ERR_IO";
    case TALUS_ERR_COMM: return "TALUS_ERR_COMM";
    case TALUS_ERR_CAPACITY: return "TALUS_ERR_CAPACITY";
    case TALUS_ERR_UNSUPPORTED: return "TALUS_ERR_UNSUPPORTED";
    case TALUS_ERR_INTERNAL: return "TALUS_ERR_INTERNAL";
    default: return "unknown status";
    }
}

const char* talus_message(void) { return thread_message().c_str(); }
int32_t talus_version(void) { return TALUS_VERSION_NUMBER; }

const char* talus_build_info(void) {
    static const std::string text = fmt::format("Talus {}.{}.{}, {}, {}", TALUS_VERSION_MAJOR, TALUS_VERSION_MINOR, TALUS_VERSION_PATCH, TALUS_BUILD_COMPILER, TALUS_BUILD_TYPE);
    return text.c_str();
}

talus_status talus_laws_init(talus_laws* out) { return init_struct(out, default_laws()); }
// The name itself is called by programs of the first header, which have room for no more.
talus_status(talus_settings_init)(talus_settings* out) { return init_struct(out, default_settings(), offsetof(talus_settings, rebalance_interval)); }
talus_status talus_settings_init_sized(talus_settings* out, size_t struct_size) { return init_struct(out, default_settings(), struct_size); }

talus_status talus_engine_create(const talus_settings* settings, talus_engine** out_engine) {
    return create(out_engine, [&] { return make_engine(settings, communicator(TALUS_SERIAL), out_engine); });
}

talus_status talus_engine_create_mpi(const talus_settings* settings, int32_t comm_f, talus_engine** out_engine) {
    return create(out_engine, [&] { return make_engine(settings, communicator(comm_f), out_engine); });
}

talus_status talus_checkpoint_load(const char* path, const talus_settings* settings, int32_t comm_f, talus_engine** out_engine) {
    return create(out_engine, [&] {
        auto comm = communicator(comm_f);
        runtime::Settings s;
        runtime::agree(*comm, [&] {
            require(out_engine, "out_engine");
            require_cpu();
            require(path, "path");
            s = to_settings(settings);
        });
        return runtime::Engine::load(path, s, std::move(comm));
    });
}

void talus_engine_destroy(talus_engine* engine) {
    if (engine == nullptr || engine->live != talus_engine::kLive) return;
    engine->live = 0;
    delete engine;
}

const char* talus_engine_message(const talus_engine* engine) { return engine == nullptr || engine->live != talus_engine::kLive ? thread_message().c_str() : engine->message.c_str(); }

talus_status talus_engine_rank(const talus_engine* engine, int32_t* out_rank, int32_t* out_ranks) {
    return with_engine<LastStep::as_it_is>(engine, [&](runtime::Engine& e) {
        if (out_rank != nullptr) *out_rank = e.state().comm->rank();
        if (out_ranks != nullptr) *out_ranks = e.state().comm->size();
    });
}

talus_status talus_rank_grid(const double lengths[3], const int32_t periodic[3], int32_t ranks, const int32_t given[3], int32_t out_grid[3]) {
    return guarded(thread_message(), [&]() -> talus_status {
        require(lengths, "lengths");
        require(out_grid, "out_grid");
        if (ranks < 1) core::fail(core::ErrorKind::argument, "ranks = {}: must be above 0", ranks);
        std::array<int, 3> wanted{};
        double box[3];
        bool wraps[3];
        for (int a = 0; a < 3; ++a) {
            box[a] = lengths[a];
            wraps[a] = periodic != nullptr && periodic[a] != 0;
            if (!(box[a] > 0.0) || !std::isfinite(box[a])) core::fail(core::ErrorKind::argument, "lengths[{}] = {}: must be a finite number above 0", a, box[a]);
            if (given == nullptr) continue;
            wanted[static_cast<std::size_t>(a)] = given[a];
            if (given[a] < 0) core::fail(core::ErrorKind::argument, "given[{}] = {}: must be 0 (chosen) or above", a, given[a]);
        }
        const std::array<int, 3> grid = core::choose_rank_grid(ranks, box, wraps, wanted);
        if (grid[0] == 0) core::fail(core::ErrorKind::argument, "given = {} {} {}: the subdomains asked for do not multiply to {} ranks", wanted[0], wanted[1], wanted[2], ranks);
        for (int a = 0; a < 3; ++a) out_grid[a] = grid[static_cast<std::size_t>(a)];
        return TALUS_OK;
    });
}

} // extern "C"
