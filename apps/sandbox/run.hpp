// run.hpp: the commands run and check.
#ifndef TALUS_SANDBOX_RUN_HPP
#define TALUS_SANDBOX_RUN_HPP

#include "command_line.hpp"
#include "failure.hpp"
#include "team.hpp"

namespace talus::sandbox {

// Returns kExitDone or kExitStopped; throws a Failure, the same on every rank, for anything else. [collective]
ExitCode run(const Team& team, const Options& options);

// Validates; with a bed file the engine checks its grains too (overlaps). [collective]
ExitCode check(const Team& team, const Options& options);

} // namespace talus::sandbox

#endif
