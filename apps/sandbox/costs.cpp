// The file of costs, JSON; all numbers in SI units, null for what was not measured:
//   format      1
//   machine     processor (model name), processors, build (talus_build_info()), ranks that measured
//   scene       grains, contacts_per_grain (between grains, each counted once), skin_diameters, history_doubles (a contact),
//               laws (a short text)
//   settling    null, or what settling a column of this sand took: key (hash of the configuration that matters), steps,
//               is_at_rest (false: given up after these steps)
//   runs        one for each number of threads that was measured: threads, settle and shorten (particle_steps_per_second of
//               a rank, rebuilds of lists included; steps_per_rebuild), busy (seconds, summed over threads; force and
//               integrate a grain and step, halo_exchange a ghost and step, binning, pair_build and rebalance a grain and
//               rebuild), idle_share (1 - busy/(threads wall)). settle is null with a bed file, halo_exchange on one rank
//   memory      of a rank with its share of the scene's grains: bytes_per_grain (most while stepping), saving_bytes_per_grain
//               (most while a checkpoint is written), base_bytes, is_measured (false: built in, the sample was too small)
//   start       seconds_per_grain (putting grains in, first lists)
//   files       bytes_per_second (writing a checkpoint)
#include "costs.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "failure.hpp"

namespace talus::sandbox {

namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr std::int64_t kFormat = 1;
constexpr const char* kCure = "measure again with --calibrate";

// Reads entries of a costs file; every fault names the file and the entry.
class Reader {
public:
    Reader(std::string place, const Json& json) : place_(std::move(place)), json_(json) {}

    Reader part(const char* name) const {
        const Json& found = entry(name);
        if (!found.is_object()) fail(name, found, "an object");
        return {path(name), found};
    }
    std::vector<Reader> list(const char* name) const {
        const Json& found = entry(name);
        if (!found.is_array() || found.empty()) fail(name, found, "a list of at least one entry");
        std::vector<Reader> parts;
        for (std::size_t k = 0; k < found.size(); ++k) parts.push_back({fmt::format("{}[{}]", path(name), k), found[k]});
        return parts;
    }
    bool is_null(const char* name) const { return entry(name).is_null(); }
    double number(const char* name, bool zero_allowed = false) const {
        const Json& found = entry(name);
        const double value = found.is_number() ? found.get<double>() : -1;
        if (!std::isfinite(value) || value < 0 || (value == 0 && !zero_allowed))
            fail(name, found, zero_allowed ? "a number from 0 on" : "a finite number above 0");
        return value;
    }
    std::int64_t whole(const char* name, std::int64_t least) const {
        const Json& found = entry(name);
        if (!found.is_number_integer() || found.get<std::int64_t>() < least)
            fail(name, found, fmt::format("a whole number from {} on", least));
        return found.get<std::int64_t>();
    }
    std::string text(const char* name) const {
        const Json& found = entry(name);
        if (!found.is_string()) fail(name, found, "a text");
        return found.get<std::string>();
    }
    bool flag(const char* name) const {
        const Json& found = entry(name);
        if (!found.is_boolean()) fail(name, found, "true or false");
        return found.get<bool>();
    }

private:
    std::string place_; // "file: " or "file: part"
    const Json& json_;

    std::string path(const char* name) const { return place_ + (place_.back() == ' ' ? "" : ".") + name; }
    const Json& entry(const char* name) const {
        if (!json_.is_object() || !json_.contains(name)) throw Failure(kExitInput, fmt::format("{}: is missing; {}", path(name), kCure));
        return json_[name];
    }
    [[noreturn]] void fail(const char* name, const Json& found, const std::string& right) const {
        throw Failure(kExitInput, fmt::format("{} = {}: must be {}; {}", path(name), found.dump(), right, kCure));
    }
};

StageCosts read_stage(const Reader& json) { return {json.number("particle_steps_per_second"), json.number("steps_per_rebuild")}; }

RunCosts read_run(const Reader& json) {
    RunCosts run;
    run.threads = static_cast<std::int32_t>(std::min<std::int64_t>(json.whole("threads", 1), INT32_MAX));
    if (!json.is_null("settle")) run.settle = read_stage(json.part("settle"));
    run.shorten = read_stage(json.part("shorten"));
    const Reader busy = json.part("busy");
    run.busy.force = busy.number("force");
    run.busy.integrate = busy.number("integrate");
    if (!busy.is_null("halo_exchange")) run.busy.halo_exchange = busy.number("halo_exchange", true);
    run.busy.binning = busy.number("binning", true);
    run.busy.pair_build = busy.number("pair_build", true);
    run.busy.rebalance = busy.number("rebalance", true);
    run.idle_share = json.number("idle_share", true);
    return run;
}

Json stage_json(const std::optional<StageCosts>& stage) {
    if (!stage) return nullptr;
    return {{"particle_steps_per_second", stage->particle_steps_per_second}, {"steps_per_rebuild", stage->steps_per_rebuild}};
}

Json run_json(const RunCosts& run) {
    Json busy = {{"force", run.busy.force}, {"integrate", run.busy.integrate}, {"halo_exchange", nullptr}};
    if (run.busy.halo_exchange) busy["halo_exchange"] = *run.busy.halo_exchange;
    busy.update({{"binning", run.busy.binning}, {"pair_build", run.busy.pair_build}, {"rebalance", run.busy.rebalance}});
    return {{"threads", run.threads},
            {"settle", stage_json(run.settle)},
            {"shorten", stage_json(run.shorten)},
            {"busy", busy},
            {"idle_share", run.idle_share}};
}

} // namespace

const RunCosts& Costs::run(std::int32_t threads) const {
    return *std::min_element(runs.begin(), runs.end(), [&](const RunCosts& a, const RunCosts& b) {
        return std::abs(a.threads - threads) < std::abs(b.threads - threads);
    });
}

Costs read_costs(const std::string& path) {
    std::ifstream stream(path);
    if (!stream)
        throw Failure(kExitInput,
                      fmt::format("{}: cannot be opened: {}; make it with --calibrate, or leave --costs out", path, std::strerror(errno)));
    std::stringstream text;
    text << stream.rdbuf();
    Json json;
    try {
        json = Json::parse(text.str());
    } catch (const Json::parse_error& error) {
        throw Failure(kExitInput, fmt::format("{}: is damaged, or not a file of costs: not JSON at byte {}; {}", path, error.byte, kCure));
    }
    const Reader all(path + ": ", json);
    if (const std::int64_t format = all.whole("format", 0); format != kFormat)
        throw Failure(kExitInput, fmt::format("{}: format = {}: this program reads format {}; {}", path, format, kFormat, kCure));
    Costs costs;
    costs.file = path;
    const Reader machine = all.part("machine"), scene = all.part("scene"), memory = all.part("memory");
    costs.processor = machine.text("processor");
    costs.processors = machine.whole("processors", 1);
    costs.build = machine.text("build");
    costs.ranks = static_cast<std::int32_t>(machine.whole("ranks", 1));
    costs.grains = scene.whole("grains", 1);
    costs.contacts_per_grain = scene.number("contacts_per_grain", true);
    costs.skin_diameters = scene.number("skin_diameters");
    costs.history_doubles = static_cast<std::int32_t>(scene.whole("history_doubles", 0));
    costs.laws = scene.text("laws");
    if (!all.is_null("settling")) {
        const Reader settling = all.part("settling");
        costs.settling = Settling{settling.text("key"), settling.whole("steps", 0), settling.flag("is_at_rest")};
    }
    for (const Reader& run : all.list("runs")) costs.runs.push_back(read_run(run));
    costs.memory = {memory.number("bytes_per_grain"), memory.number("saving_bytes_per_grain"), memory.number("base_bytes", true),
                    memory.flag("is_measured")};
    costs.start_seconds_per_grain = all.part("start").number("seconds_per_grain");
    costs.write_bytes_per_second = all.part("files").number("bytes_per_second");
    return costs;
}

void write_costs(const Costs& costs, const std::string& path) {
    Json json;
    json["format"] = kFormat;
    json["machine"] = {{"processor", costs.processor}, {"processors", costs.processors}, {"build", costs.build}, {"ranks", costs.ranks}};
    json["scene"] = {{"grains", costs.grains},
                     {"contacts_per_grain", costs.contacts_per_grain},
                     {"skin_diameters", costs.skin_diameters},
                     {"history_doubles", costs.history_doubles},
                     {"laws", costs.laws}};
    json["settling"] = nullptr;
    if (const auto& settling = costs.settling)
        json["settling"] = {{"key", settling->key}, {"steps", settling->steps}, {"is_at_rest", settling->is_at_rest}};
    for (const RunCosts& run : costs.runs) json["runs"].push_back(run_json(run));
    json["memory"] = {{"bytes_per_grain", costs.memory.bytes_per_grain},
                      {"saving_bytes_per_grain", costs.memory.saving_bytes_per_grain},
                      {"base_bytes", costs.memory.base_bytes},
                      {"is_measured", costs.memory.is_measured}};
    json["start"] = {{"seconds_per_grain", costs.start_seconds_per_grain}};
    json["files"] = {{"bytes_per_second", costs.write_bytes_per_second}};

    std::error_code error;
    if (fs::path(path).has_parent_path()) fs::create_directories(fs::path(path).parent_path(), error);
    const std::string part = path + ".part";
    std::ofstream stream(part);
    stream << json.dump(2) << "\n";
    stream.close();
    if (!stream)
        throw Failure(kExitIo, fmt::format("{}: cannot be written: {}; give another file with --costs", path, std::strerror(errno)));
    fs::rename(part, path, error);
    if (error) throw Failure(kExitIo, fmt::format("{}: cannot be written: {}; give another file with --costs", path, error.message()));
}

std::string default_costs_path() {
    constexpr const char* kName = "talus-costs.json";
    if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache != nullptr && *cache == '/') return std::string(cache) + "/" + kName;
    if (const char* home = std::getenv("HOME"); home != nullptr && *home == '/') return std::string(home) + "/.cache/" + kName;
    return kName;
}

std::string laws_text(const Config::Laws& laws) {
    constexpr const char* kNormal[] = {"Hertz", "linear"};
    constexpr const char* kTangential[] = {"force rescaled", "force", "displacement", "frictionless"};
    constexpr const char* kRolling[] = {"no rolling", "constant rolling", "spring rolling"};
    return fmt::format("{}, {}, {}", kNormal[laws.normal], kTangential[laws.tangential], kRolling[laws.rolling]);
}

std::int32_t history_doubles(const Config::Laws& laws) {
    if (laws.rolling == TALUS_ROLLING_SPRING) return 7;
    return laws.tangential == TALUS_TANGENTIAL_NONE ? 0 : 4;
}

bool saves(const Config& config) {
    return config.run.checkpoint || config.run.checkpoint_every > 0 || (config.bed.file.empty() && config.settle.keep);
}

namespace {

// More bytes a grain than were measured: with other histories, and on a rank with fewer grains. Tiles at the surface have more grains
// of others to know, and more lists are held twice while they are rebuilt: measured as N^(2/3) bytes for N = 40,000 to 2 million grains.
double more_bytes(const Costs& costs, std::int32_t doubles, double grains) {
    constexpr double kSurface = 7000;
    const double measured = static_cast<double>(costs.grains) / costs.ranks;
    const double surface = kSurface * (1 / std::cbrt(std::max(grains, 1e3)) - 1 / std::cbrt(std::max(measured, 1e3)));
    return 8.0 * (doubles - costs.history_doubles) * costs.contacts_per_grain + surface;
}

} // namespace

MemoryCosts reference_memory(const Costs& costs) {
    const Costs reference = reference_costs();
    MemoryCosts memory = reference.memory;
    const double more = more_bytes(reference, costs.history_doubles, static_cast<double>(costs.grains) / costs.ranks);
    memory.bytes_per_grain += more;
    memory.saving_bytes_per_grain += more;
    return memory;
}

double rank_bytes(const Costs& costs, const Config& config, double grains_and_ghosts) {
    const MemoryCosts& memory = costs.memory;
    const double most = saves(config) ? std::max(memory.bytes_per_grain, memory.saving_bytes_per_grain) : memory.bytes_per_grain;
    return memory.base_bytes + (most + more_bytes(costs, history_doubles(config.laws), grains_and_ghosts)) * grains_and_ghosts;
}

} // namespace talus::sandbox
