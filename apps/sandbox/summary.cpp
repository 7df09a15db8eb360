#include "summary.hpp"

#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "config_keys.hpp"

namespace talus::sandbox {

namespace {

using Json = nlohmann::ordered_json;

Json phases_json(const Engine& engine) {
    Json json = Json::object();
    constexpr std::int32_t kMost = 64;
    std::vector<talus_phase> phases(kMost);
    talus_phase_init(phases.data());
    std::int32_t count = kMost;
    if (talus_engine_phases(engine.get(), &count, phases.data()) != TALUS_OK) return json;
    for (std::int32_t i = 0; i < count; ++i)
        json[phases[i].name] = {{"min", phases[i].min}, {"mean", phases[i].mean}, {"max", phases[i].max}, {"calls", phases[i].calls}};
    return json;
}

// What each rank holds and sends, with the lists at the end of the run.
Json ranks_json(const Engine& engine, std::int32_t n) {
    std::vector<talus_rank> ranks(static_cast<std::size_t>(n));
    Json json = Json::array();
    talus_rank_init(ranks.data());
    if (talus_engine_ranks(engine.get(), &n, ranks.data()) != TALUS_OK) return json;
    for (const talus_rank& r : ranks)
        json.push_back({{"rank", r.rank},
                        {"lo", r.lo},
                        {"hi", r.hi},
                        {"particles", r.particles},
                        {"ghosts", r.ghosts},
                        {"tiles", r.tiles},
                        {"halo_messages", r.halo_messages},
                        {"halo_bytes", r.halo_bytes},
                        {"busy_seconds_per_step", r.busy}});
    return json;
}

Json stages_json(const std::vector<StageRecord>& stages, std::int64_t particles) {
    Json json = Json::array();
    for (const StageRecord& stage : stages) {
        Json item;
        item["name"] = stage.name;
        item["steps"] = stage.steps;
        item["time"] = stage.time;
        item["wall_seconds"] = stage.wall_seconds;
        item["stepping_seconds"] = stage.stepping_seconds;
        if (stage.steps > 0 && stage.stepping_seconds > 0)
            item["particle_steps_per_second"] = static_cast<double>(stage.steps) * static_cast<double>(particles) / stage.stepping_seconds;
        if (!stage.note.empty()) item["note"] = stage.note;
        json.push_back(item);
    }
    return json;
}

Json snapshots_json(const std::vector<SnapshotRecord>& snapshots) {
    Json json = Json::array();
    for (const SnapshotRecord& record : snapshots)
        json.push_back({{"file", record.file}, {"step", record.step}, {"time", record.time}, {"shortening", record.shortening}});
    return json;
}

// Every key with its value, as typed numbers; null for an optional key left out.
Json configuration_json(const Config& config) {
    Json json;
    for (const Key& key : config_keys()) {
        Json& item = json[key.table][key.name];
        const std::string text = value_text(key, config);
        // TOML's and JSON's notation of these values is the same.
        item = text.empty() ? Json(nullptr) : Json::parse(text, nullptr, false);
        if (item.is_discarded()) item = text;
    }
    return json;
}

} // namespace

std::string summary_text(const Scene& scene, const Config& config, const Plan& plan, const RunRecord& run) {
    Json json;
    json["status"] = run.status;
    json["stopped"] = run.status == "stopped";
    if (!run.error.empty()) json["error"] = run.error;

    std::int64_t steps = 0;
    double stepping = 0;
    for (const StageRecord& stage : run.stages) {
        steps += stage.steps;
        stepping += stage.stepping_seconds;
    }
    talus_state state;
    talus_state_init(&state);
    const bool has_state = talus_engine_state(scene.engine.get(), &state) == TALUS_OK;
    if (has_state) {
        json["particles"] = state.particles;
        json["ranks"] = state.ranks;
        json["threads"] = state.threads;
        json["threads_observed"] = state.threads_observed;
    } else {
        json["particles"] = plan.grains;
        json["threads"] = run.threads;
    }
    json["steps"] = steps;                    // taken by this process, in all stages
    if (has_state) json["time"] = state.time; // of the engine's clock: settling and its kept steps included
    json["wall_seconds"] = run.wall_seconds;
    json["stepping_seconds"] = stepping;
    const double particles = has_state ? static_cast<double>(state.particles) : static_cast<double>(plan.grains);
    json["particle_steps_per_second"] = stepping > 0 ? static_cast<double>(steps) * particles / stepping : 0.0;
    if (has_state) {
        json["rebuilds"] = state.rebuilds;
        json["rebalances"] = state.rebalances;
        json["migrations"] = state.migrations;
        json["contacts"] = state.contacts;
        json["wall_contacts"] = state.wall_contacts;
        json["sliding_contacts"] = state.sliding_contacts;
        json["bytes_per_particle"] = state.bytes_per_particle;
        json["imbalance"] = state.imbalance;
        json["halo"] = {{"messages_per_step", state.halo_messages}, {"bytes_per_step", state.halo_bytes}};
        json["subdomains"] = ranks_json(scene.engine, state.ranks);
        json["skin"] = state.skin;
        json["kinetic_energy"] = state.kinetic_energy;
        json["max_overlap"] = state.max_overlap;
        json["state_digest"] = fmt::format("{:016x}{:016x}", state.digest_hi, state.digest_lo);
    }
    json["ghosts"] = run.ghosts;
    json["peak_bytes"] = run.peak_bytes;
    json["phases"] = phases_json(scene.engine);
    json["time_step"] = plan.step;
    json["time_step_rayleigh_fraction"] = plan.step / plan.critical_step;
    json["shortening"] = {{"start_step", run.shorten_start_step},
                          {"start_time", run.shorten_start_time},
                          {"steps", run.shorten_steps},
                          {"time", static_cast<double>(run.shorten_steps) * plan.step},
                          {"distance", plan.shortening.travel(run.shorten_steps)},
                          {"speed", plan.shortening.speed()},
                          {"ramp", plan.shortening.ramp()}};
    json["stages"] = stages_json(run.stages, static_cast<std::int64_t>(particles));
    json["snapshots"] = snapshots_json(run.snapshots);
    json["box"] = {{"lo", plan.lo}, {"hi", plan.hi}, {"periodic_z", config.box.periodic_z}};
    json["configuration"] = configuration_json(config);
    json["version"] = fmt::format("{}.{}.{}", talus_version() / 10000, talus_version() / 100 % 100, talus_version() % 100);
    json["build"] = talus_build_info();
    return json.dump(2) + "\n";
}

} // namespace talus::sandbox
