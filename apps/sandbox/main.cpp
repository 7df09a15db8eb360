// talus-sandbox: sandbox experiments on the C ABI of Talus. This file starts and ends MPI and turns failures into exit
// codes; run.hpp has the rest.
#include <mpi.h>

#include <exception>
#include <new>

#include <fmt/format.h>

#include "command_line.hpp"
#include "config_keys.hpp"
#include "failure.hpp"
#include "planning.hpp"
#include "process_memory.hpp"
#include "run.hpp"
#include "signals.hpp"
#include "team.hpp"

namespace {

using namespace talus::sandbox;

int command(const Team& team, int argc, char** argv) {
    Options options;
    int exit_code = kExitDone;
    if (!read_command_line(argc, argv, team.is_root(), options, exit_code)) return exit_code;
    switch (options.command) {
    case Command::kRun:
        return run(team, options);
    case Command::kCheck:
        return check(team, options);
    case Command::kPlan:
        return plan_run(team, options);
    case Command::kKeys:
        if (team.is_root()) fmt::print("{}", key_list());
        break;
    }
    return kExitDone;
}

// A Failure is known to every rank: one prints and all leave. Anything else may have happened here only, and the other
// ranks may wait for this one for ever: the job is ended.
int guarded_command(int argc, char** argv) {
    const Team team(MPI_COMM_WORLD);
    const auto fail = [&team](ExitCode code, const char* text, bool is_everywhere) {
        std::fflush(stdout);
        if (team.is_root() || !is_everywhere) fmt::print(stderr, "talus-sandbox: {}\n", text);
        std::fflush(stderr);
        if (!is_everywhere && team.size() > 1) MPI_Abort(MPI_COMM_WORLD, code);
        return static_cast<int>(code);
    };
    try {
        return command(team, argc, argv);
    } catch (const Failure& failure) {
        return fail(failure.code(), failure.what(), failure.code() != kExitMpi);
    } catch (const std::bad_alloc&) {
        return fail(kExitInternal, "out of memory", false);
    } catch (const std::exception& error) {
        return fail(kExitInternal, error.what(), false);
    }
}

} // namespace

int main(int argc, char** argv) {
    talus::keep_large_blocks_apart();
    int level = MPI_THREAD_SINGLE;
    if (MPI_Init_thread(&argc, &argv, MPI_THREAD_SERIALIZED, &level) != MPI_SUCCESS) return kExitMpi;
    install_signal_handlers();
    int exit_code = kExitMpi;
    if (level < MPI_THREAD_SERIALIZED)
        fmt::print(stderr, "talus-sandbox: this MPI gives thread level {}; Talus needs MPI_THREAD_SERIALIZED\n", level);
    else
        exit_code = guarded_command(argc, argv);
    MPI_Finalize();
    return exit_code;
}
