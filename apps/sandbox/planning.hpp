// planning.hpp: the command plan.
#ifndef TALUS_SANDBOX_PLANNING_HPP
#define TALUS_SANDBOX_PLANNING_HPP

#include "command_line.hpp"
#include "failure.hpp"
#include "team.hpp"

namespace talus::sandbox {

// Tells what a run would take, by costs from a file, measured now, or built in. [collective]
ExitCode plan_run(const Team& team, const Options& options);

} // namespace talus::sandbox

#endif
