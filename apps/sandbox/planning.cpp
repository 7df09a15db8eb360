#include "planning.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>

#include "calibrate.hpp"
#include "forecast.hpp"
#include "input.hpp"

namespace talus::sandbox {

namespace {

// An hour's wait for a file that cannot be written would be a pity.
void check_writable(const std::string& path) {
    const std::filesystem::path folder = std::filesystem::absolute(path).parent_path();
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    const std::string probe = path + ".part";
    std::ofstream stream(probe);
    if (!stream)
        throw Failure(kExitIo, fmt::format("{}: cannot be written: {}; give another file with --costs", path, std::strerror(errno)));
    stream.close();
    std::filesystem::remove(probe, error);
}

Costs costs_of(const Team& team, const Options& options, const Input& input) {
    const std::string path = options.costs.empty() ? default_costs_path() : options.costs;
    Costs costs;
    if (options.calibrate) {
        team.on_root([&] { check_writable(path); });
        costs = calibrate(team, input, team.from_root(path + ".ckpt"));
        costs.file = path;
        team.on_root([&] {
            write_costs(costs, path);
            // What is told now is what will be told from the file.
            costs = read_costs(path);
        });
        return costs;
    }
    team.on_root([&] {
        std::error_code error;
        const bool is_there = !options.costs.empty() || std::filesystem::exists(path, error);
        costs = is_there ? read_costs(path) : reference_costs();
    });
    return costs;
}

void write_json(const std::string& path, const std::string& text) {
    std::ofstream stream(path);
    stream << text;
    stream.close();
    if (!stream)
        throw Failure(kExitIo, fmt::format("{}: cannot be written: {}; give another file with --json", path, std::strerror(errno)));
}

} // namespace

ExitCode plan_run(const Team& team, const Options& options) {
    const Input input = read_input(team, options);
    const Costs costs = costs_of(team, options, input);
    team.on_root([&] {
        Machine machine;
        machine.ranks = options.ranks.value_or(team.size());
        machine.threads = input.threads;
        machine.latency = options.latency;
        machine.bandwidth = options.bandwidth;
        machine.write_bytes_per_second = options.disk.value_or(0);
        const Forecast forecast = make_forecast(input.config, input.plan, costs, machine);
        const std::string json = forecast_json(input.config, input.plan, costs, forecast);
        if (options.json != "-") fmt::print("{}", forecast_text(input.config, input.plan, costs, forecast));
        if (options.json == "-")
            fmt::print("{}", json);
        else if (!options.json.empty())
            write_json(options.json, json);
        std::fflush(stdout);
    });
    return kExitDone;
}

} // namespace talus::sandbox
