#include "input.hpp"

#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <fmt/format.h>

#include "config_read.hpp"
#include "forecast.hpp"

namespace talus::sandbox {

namespace {

std::string read_text(const std::string& path) {
    std::error_code error;
    if (std::filesystem::is_directory(path, error)) throw Failure(kExitInput, path + ": is a folder; give a configuration file");
    std::ifstream stream(path, std::ios::binary);
    if (!stream) throw Failure(kExitInput, fmt::format("{}: cannot be opened: {}", path, std::strerror(errno)));
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
}

std::vector<Setting> settings_of(const Options& options) {
    std::vector<Setting> settings;
    for (const std::string& set : options.sets) settings.push_back({"--set", set});
    if (options.threads) settings.push_back({"--threads", fmt::format("run.threads={}", *options.threads)});
    return settings;
}

// The processors this rank may use: its own if it was bound to some, else its share of the machine.
std::int64_t processors(const Team& team) {
    const std::int64_t online = std::max(1L, sysconf(_SC_NPROCESSORS_ONLN));
    cpu_set_t mask;
    const std::int64_t allowed = sched_getaffinity(0, sizeof mask, &mask) == 0 ? CPU_COUNT(&mask) : online;
    const std::int64_t share = allowed < online ? allowed : online / team.size_on_node();
    return team.smallest(std::max<std::int64_t>(1, share));
}

} // namespace

Input read_input(const Team& team, const Options& options) {
    Input input;
    std::string text;
    BedSummary bed;
    const std::vector<Setting> settings = settings_of(options);
    const auto parse = [&](Faults& faults) { input.config = read_config(text, options.config, settings, faults); };
    const auto plan = [&](bool has_bed, Faults& faults) {
        const std::optional<BedSummary> summary = has_bed ? std::optional(bed) : std::nullopt;
        input.plan = make_plan(input.config, summary, options.steps, options.ranks.value_or(team.size()), faults);
    };
    team.on_root([&] {
        text = read_text(options.config);
        Faults faults;
        parse(faults);
        bool has_bed = false;
        const std::string& file = input.config.bed.file;
        if (!file.empty() && input.config.refused.count("bed.axes") == 0) {
            const std::size_t before = faults.count();
            input.bed = read_bed(file, input.config.bed.axes, faults);
            has_bed = faults.count() == before;
            bed = input.bed.summary();
        }
        plan(has_bed, faults);
        faults.throw_if_any(options.config);
    });
    // The other ranks come to the same configuration from the same text; a list of faults can only be empty here.
    text = team.from_root(text);
    bed = share(team, bed);
    if (!team.is_root()) {
        Faults faults;
        parse(faults);
        plan(!input.config.bed.file.empty(), faults);
        faults.throw_if_any(options.config);
    }
    const std::int64_t own_share = processors(team);
    input.threads = static_cast<std::int32_t>(input.config.run.threads.value_or(own_share));
    return input;
}

void check_memory(const Team& team, const Config& config, const Plan& plan) {
    std::ifstream stream("/proc/meminfo");
    std::string word;
    std::int64_t kilobytes = std::numeric_limits<std::int64_t>::max() / 1024;
    while (stream >> word)
        if (word == "MemAvailable:") stream >> kilobytes;
    const double free = 1024.0 * static_cast<double>(team.smallest(kilobytes));
    const double on_node = static_cast<double>(team.largest(team.size_on_node()));
    const double needed = expected_rank_bytes(config, plan, team.size()) * on_node;
    if (needed > free)
        throw Failure(kExitInput, fmt::format("{} grains need about {:.0f} GB of memory on each machine, of which {:.0f} GB "
                                              "are free; use more machines, larger grains or a smaller box",
                                              plan.grains, needed / 1e9, free / 1e9));
}

} // namespace talus::sandbox
