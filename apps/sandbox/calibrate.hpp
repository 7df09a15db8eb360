// calibrate.hpp: measures what an experiment costs on this machine, in about a minute. The sample (sample.hpp) is stepped as the
// experiment's stages step the whole: at rest without friction, then with friction and with the walls at their full speed. Times are
// medians over short blocks of steps, so that a busy machine disturbs them little.
#ifndef TALUS_SANDBOX_CALIBRATE_HPP
#define TALUS_SANDBOX_CALIBRATE_HPP

#include <string>

#include "costs.hpp"
#include "input.hpp"

namespace talus::sandbox {

// Measures with input.threads and with one thread, on all ranks of the team. The costs are whole on rank 0 only.
// @param scratch  a file that is written and taken away again, where results would be written [collective]
Costs calibrate(const Team& team, const Input& input, const std::string& scratch);

} // namespace talus::sandbox

#endif
