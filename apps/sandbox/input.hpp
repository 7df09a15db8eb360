// input.hpp: everything a run starts from, read and checked by rank 0 and shared by all.
#ifndef TALUS_SANDBOX_INPUT_HPP
#define TALUS_SANDBOX_INPUT_HPP

#include "bed_file.hpp"
#include "command_line.hpp"
#include "config.hpp"
#include "plan.hpp"
#include "team.hpp"

namespace talus::sandbox {

struct Input {
    Config config;
    Plan plan;
    Bed bed; // on rank 0, with [bed] file
    std::int32_t threads = 1;
};

// Throws a Failure that lists all faults of configuration and bed file at once. [collective]
Input read_input(const Team& team, const Options& options);

// Throws if the planned grains do not fit into the memory of every machine in use. [collective]
void check_memory(const Team& team, const Config& config, const Plan& plan);

} // namespace talus::sandbox

#endif
