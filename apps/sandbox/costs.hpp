// costs.hpp: what a grain, a step and a byte cost on a machine, measured by calibrate.hpp and kept in a JSON file; the numbers that
// forecast.hpp works with. costs.cpp documents the file.
#ifndef TALUS_SANDBOX_COSTS_HPP
#define TALUS_SANDBOX_COSTS_HPP

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "config.hpp"

namespace talus::sandbox {

struct StageCosts {
    double particle_steps_per_second = 0; // of a rank, rebuilds of lists included
    double steps_per_rebuild = 0;         // at least, if no rebuild was seen
};

// Busy time, summed over the threads of a rank.
struct BusyCosts {
    double force = 0;                    // [s] a grain and step
    double integrate = 0;                // [s] a grain and step
    std::optional<double> halo_exchange; // [s] a ghost and step, packing and unpacking; needs two ranks
    double binning = 0;                  // [s] a grain and rebuild
    double pair_build = 0;               // [s] a grain and rebuild
    double rebalance = 0;                // [s] a grain and rebuild
};

struct RunCosts {
    std::int32_t threads = 1;
    std::optional<StageCosts> settle; // not with a bed file
    StageCosts shorten;
    BusyCosts busy;        // while shortening
    double idle_share = 0; // of the threads' time, in no phase
};

struct MemoryCosts {
    double bytes_per_grain = 0;        // most that is held while stepping, rebuilds of lists included
    double saving_bytes_per_grain = 0; // ... and while a checkpoint is written
    double base_bytes = 0;             // of a process without grains
    bool is_measured = false;          // else built in: the sample was too small
};

// The settling of a column of the same sand, see sample.hpp.
struct Settling {
    std::string key; // settling_key() of its configuration
    std::int64_t steps = 0;
    bool is_at_rest = false; // else it was given up after so many steps
};

struct Costs {
    std::string file; // empty: built in
    std::string processor;
    std::int64_t processors = 0;
    std::string build;
    std::int32_t ranks = 1; // that measured

    std::int64_t grains = 0;          // of the sample, over all ranks
    double contacts_per_grain = 0;    // between grains, each counted once
    double skin_diameters = 0;        // the list skin over the largest diameter
    std::int32_t history_doubles = 0; // a contact, under the laws measured
    std::string laws;
    std::optional<Settling> settling;

    std::vector<RunCosts> runs; // by number of threads
    MemoryCosts memory;
    double start_seconds_per_grain = 0; // putting grains in and making the first lists
    double write_bytes_per_second = 0;  // of a checkpoint

    bool is_built_in() const { return file.empty(); }
    // The run whose threads are nearest.
    const RunCosts& run(std::int32_t threads) const;
};

// Measured once, on a machine that is not this one.
Costs reference_costs();
// ... of its memory, with the histories of other costs.
MemoryCosts reference_memory(const Costs& costs);

// Throws a Failure that names the file, the entry and what would be right. [local]
Costs read_costs(const std::string& path);
void write_costs(const Costs& costs, const std::string& path);
// $XDG_CACHE_HOME/talus-costs.json, else ~/.cache/talus-costs.json, else talus-costs.json in the working folder.
std::string default_costs_path();

// The contact laws in a few words, and the doubles of history that they keep of a contact.
std::string laws_text(const Config::Laws& laws);
std::int32_t history_doubles(const Config::Laws& laws);

// Whether the experiment writes checkpoints, of a settled bed or of the state.
bool saves(const Config& config);
// Most bytes that a rank holds in an experiment, by its grains and ghosts: the one home of this number.
double rank_bytes(const Costs& costs, const Config& config, double grains_and_ghosts);

} // namespace talus::sandbox

#endif
