#include "command_line.hpp"

#include <iostream>
#include <sstream>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <talus.h>

#include "failure.hpp"

namespace talus::sandbox {

namespace {

constexpr const char* kEpilogue =
    R"(Exit codes
  0 done                      4 a file could not be read or written
  1 internal error            5 MPI failed
  2 wrong input               6 stopped on request (Ctrl-C, SIGTERM, SIGUSR1);
  3 unstable, or a grain lost   everything has been written

Every configuration key, with unit and default, is listed by `talus-sandbox keys`
and explained at the head of configs/paper.toml.

Ranks and threads: mpirun -n 4 --bind-to none talus-sandbox run ... --threads 2
The result has the same bits on any number of either.)";

std::string version_text() {
    const int number = talus_version();
    return fmt::format("talus-sandbox {}.{}.{} ({})", number / 10000, number / 100 % 100, number % 100, talus_build_info());
}

constexpr const char* kPlanEpilogue =
    R"(Times and memory come from costs that were measured: `talus-sandbox plan CONFIG --calibrate` steps a small sample of
the same sand as CONFIG would, for about a minute, and keeps what it finds in a file. With --threads T it measures T
threads and one; under `mpirun -n 2 --bind-to none` also the cost of halos. Do so on a machine like those that will
compute, on which nothing else runs. The file is $XDG_CACHE_HOME/talus-costs.json, else ~/.cache/talus-costs.json,
unless --costs names another. Without one, built-in costs of some machine are used, and told to be.

  talus-sandbox plan CONFIG --calibrate --threads 8
  talus-sandbox plan CONFIG --ranks 16384 --threads 8 --latency 1.5e-6 --bandwidth 5e9)";

void add_plan_options(CLI::App* plan, Options& options) {
    const auto rate = CLI::Range(1.0, 1e18);
    plan->add_option("--ranks", options.ranks, "MPI ranks to plan for; default: those that plan")->type_name("R")->check(CLI::Range(1, 10'000'000));
    plan->add_flag("--calibrate", options.calibrate, "measure the costs of this experiment on this machine, and keep them");
    plan->add_option("--costs", options.costs, "file of costs, read or, with --calibrate, written")->type_name("FILE");
    plan->add_option("--latency", options.latency, "of a message [s]; default 2e-6")->type_name("S")->check(CLI::Range(0.0, 1.0));
    plan->add_option("--bandwidth", options.bandwidth, "of the network, a rank [byte/s]; default 10e9")->type_name("B")->check(rate);
    plan->add_option("--disk", options.disk, "rate of writing files, all ranks together [byte/s]; default: as measured by one rank")
        ->type_name("B")
        ->check(rate);
    plan->add_option("--json", options.json, "write the forecast in JSON; - to the standard output, and nothing else there")->type_name("FILE");
}

} // namespace

bool read_command_line(int argc, char** argv, bool is_speaker, Options& out_options, int& out_exit_code) {
    Options options;
    CLI::App app("Sandbox experiments with Talus: a bed of sand is shortened until it faults.", "talus-sandbox");
    app.footer(kEpilogue);
    app.set_version_flag("--version", version_text());
    app.require_subcommand(1);

    const auto add_inputs = [&options](CLI::App* command) {
        command->add_option("CONFIG", options.config, "configuration file (TOML)")->required();
        // One value each time: a second word after --set is not another setting.
        command->add_option("--set", options.sets, "change one key: table.key=value, in TOML syntax; may be repeated")
            ->type_name("KEY=VALUE")
            ->allow_extra_args(false);
        command->add_option("--steps", options.steps, "number of steps of the shortening stage")
            ->type_name("N")
            ->check(CLI::Range(std::int64_t{0}, std::int64_t{1'000'000'000'000}));
        command->add_option("--threads", options.threads, "worker threads of each rank (run.threads)")->type_name("N");
    };
    CLI::App* run = app.add_subcommand("run", "fill, settle and shorten a sandbox");
    add_inputs(run);
    run->add_option("--out", options.out, "output folder; made if it does not exist")->type_name("DIR")->required();
    run->add_option("--trace", options.trace, "write the timeline of some steps in Chrome trace format")->type_name("FILE");
    run->footer(kEpilogue);
    CLI::App* check = app.add_subcommand("check", "list every fault of a configuration and its bed file; run nothing");
    add_inputs(check);
    CLI::App* plan = app.add_subcommand("plan", "tell what a run will take: steps, memory, files, messages, wall time; run nothing");
    add_inputs(plan);
    add_plan_options(plan, options);
    plan->footer(kPlanEpilogue);
    CLI::App* keys = app.add_subcommand("keys", "list every configuration key with unit, range, default and meaning");

    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        std::ostringstream out;
        std::ostringstream err;
        const bool is_mistake = app.exit(error, out, err) != 0;
        if (is_speaker) {
            std::cout << out.str();
            std::cerr << err.str();
        }
        out_exit_code = is_mistake ? kExitInput : kExitDone;
        return false;
    }
    options.command = *check ? Command::kCheck : *plan ? Command::kPlan : *keys ? Command::kKeys : Command::kRun;
    out_options = std::move(options);
    return true;
}

} // namespace talus::sandbox
