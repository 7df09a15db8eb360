// What a forecast says, to people and to programs.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "forecast.hpp"
#include "progress.hpp"

namespace talus::sandbox {

namespace {

std::string size_text(double bytes) {
    if (bytes < 0.9995e6) return fmt::format("{:.3g} kB", bytes / 1e3);
    if (bytes < 0.9995e9) return fmt::format("{:.3g} MB", bytes / 1e6);
    if (bytes < 0.9995e12) return fmt::format("{:.3g} GB", bytes / 1e9);
    return fmt::format("{:.4g} TB", bytes / 1e12);
}

std::string origin_text(const Costs& costs) {
    if (costs.is_built_in())
        return "costs       NOT OF THIS MACHINE: built in, measured once on another; measure yours with --calibrate (a minute)\n";
    return fmt::format("costs       {}: {}, {} processors, {} grains on {} {}\n", costs.file, costs.processor, costs.processors,
                       costs.grains, costs.ranks, costs.ranks == 1 ? "rank" : "ranks");
}

} // namespace

std::string memory_text(const Config& config, const Plan& plan, std::int32_t ranks) {
    return fmt::format("memory      about {} {}\n", size_text(expected_rank_bytes(config, plan, ranks)),
                       ranks == 1 ? "at most" : "a rank at most");
}

std::string forecast_text(const Config& config, const Plan& plan, const Costs& costs, const Forecast& f) {
    const Machine& m = f.machine;
    std::string text = plan_text(config, plan) + origin_text(costs);
    text += fmt::format("ranks       {} with {} {} each\n", m.ranks, m.threads, m.threads == 1 ? "thread" : "threads");
    text += fmt::format("subdomains  {} x {} x {} of {:.4g} x {:.4g} x {:.4g} mm of sand, {:.4g} grains in the fullest\n", f.halo.grid[0],
                        f.halo.grid[1], f.halo.grid[2], 1e3 * f.halo.size[0], 1e3 * f.halo.size[1], 1e3 * f.halo.size[2], f.rank_grains);
    text += m.ranks == 1 ? "halo        none\n"
                         : fmt::format("halo        {:.4g} ghosts, {} and {:g} messages a step and rank\n", f.halo.ghosts,
                                       size_text(f.halo.bytes), f.halo.messages);
    text += fmt::format("memory      {} at most on a rank, {} in all\n", size_text(f.rank_bytes), size_text(f.bytes));
    text += "files       ";
    if (f.files.settled_bed > 0) text += fmt::format("settled bed {}, ", size_text(f.files.settled_bed));
    if (f.files.checkpoints > 0) text += fmt::format("checkpoint {} written {} x, ", size_text(f.files.checkpoint), f.files.checkpoints);
    text += fmt::format("{} snapshots of {}: {}, walls.csv {}; {} in all\n", f.files.snapshots, size_text(f.files.snapshot),
                        size_text(f.files.snapshot * static_cast<double>(f.files.snapshots)), size_text(f.files.walls),
                        size_text(f.files.on_disk));
    const auto stage = [&](const char* name, const StageForecast& s) {
        const double speed = s.seconds > 0 ? static_cast<double>(s.steps) * static_cast<double>(plan.grains) / s.seconds : 0;
        const std::string network =
            m.ranks == 1 ? "" : fmt::format(", {:.2g} of it network", s.seconds > 0 ? s.network_seconds / s.seconds : 0);
        return fmt::format("{:<11} {} for {} steps, {:.3g} M particle-steps/s{}\n", name, duration_text(s.seconds), s.steps, speed / 1e6,
                           network);
    };
    if (!plan.has_bed_file) text += stage("settle", f.settle);
    text += stage("shorten", f.shorten);
    text += fmt::format("total       {}, of it {} to start and {} for files\n", duration_text(f.seconds), duration_text(f.start_seconds),
                        duration_text(f.file_seconds));
    text += "assumed\n";
    for (const std::string& line : f.assumptions) text += "  " + line + "\n";
    return text;
}

std::string forecast_json(const Config& config, const Plan& plan, const Costs& costs, const Forecast& f) {
    using Json = nlohmann::ordered_json;
    const auto stage = [](const StageForecast& s) {
        return Json{{"steps", s.steps}, {"wall_seconds", s.seconds}, {"network_seconds", s.network_seconds}};
    };
    Json json;
    json["configuration"] = config.source;
    json["grains"] = plan.grains;
    json["time_step"] = plan.step;
    json["box"] = {{"lo", plan.lo}, {"hi", plan.hi}};
    json["costs"] = {{"file", costs.is_built_in() ? Json(nullptr) : Json(costs.file)},
                     {"is_of_this_machine", !costs.is_built_in()},
                     {"processor", costs.processor}};
    json["ranks"] = f.machine.ranks;
    json["threads"] = f.machine.threads;
    json["network"] = {{"latency", f.machine.latency}, {"bandwidth", f.machine.bandwidth}};
    json["subdomains"] = {{"grid", f.halo.grid}, {"size", f.halo.size}, {"grains", f.rank_grains}};
    json["halo"] = {{"ghosts", f.halo.ghosts}, {"bytes_per_step", f.halo.bytes}, {"messages_per_step", f.halo.messages}};
    json["memory"] = {{"rank_bytes", f.rank_bytes}, {"bytes", f.bytes}};
    json["files"] = {{"settled_bed_bytes", f.files.settled_bed}, {"checkpoint_bytes", f.files.checkpoint},
                     {"checkpoints", f.files.checkpoints},       {"snapshot_bytes", f.files.snapshot},
                     {"snapshots", f.files.snapshots},           {"walls_bytes", f.files.walls},
                     {"bytes_on_disk", f.files.on_disk},         {"bytes_written", f.files.written}};
    json["settle"] = plan.has_bed_file ? Json(nullptr) : stage(f.settle);
    if (!plan.has_bed_file) {
        json["settle"]["cap_steps"] = plan.settle_cap(config);
        json["settle"]["is_measured"] = f.settling_is_measured;
    }
    json["shorten"] = stage(f.shorten);
    json["start_seconds"] = f.start_seconds;
    json["file_seconds"] = f.file_seconds;
    json["wall_seconds"] = f.seconds;
    json["assumptions"] = f.assumptions;
    return json.dump(2) + "\n";
}

} // namespace talus::sandbox
