// command_line.hpp: what the user typed.
#ifndef TALUS_SANDBOX_COMMAND_LINE_HPP
#define TALUS_SANDBOX_COMMAND_LINE_HPP

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace talus::sandbox {

enum class Command { kRun, kCheck, kPlan, kKeys };

struct Options {
    Command command = Command::kRun;
    std::string config;
    std::string out;
    std::optional<std::int64_t> threads;
    std::optional<std::int64_t> steps; // of the shortening stage
    std::vector<std::string> sets;     // table.key=value
    std::string trace;

    // Of `plan`.
    std::optional<std::int32_t> ranks; // to plan for; the ranks that plan if not given
    bool calibrate = false;
    std::string costs;          // a file; empty: the default one, if it exists
    double latency = 2e-6;      // [s]
    double bandwidth = 10e9;    // [byte/s] of a rank
    std::optional<double> disk; // [byte/s]
    std::string json;           // a file, or - for the standard output
};

// Reads the command line. Returns false when the program is to end with `out_exit_code`: after --help, --version or a
// mistake; `is_speaker` ranks print which. [local, the same on every rank]
bool read_command_line(int argc, char** argv, bool is_speaker, Options& out_options, int& out_exit_code);

} // namespace talus::sandbox

#endif
