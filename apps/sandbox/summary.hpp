// summary.hpp: summary.json, what a run was and how fast.
#ifndef TALUS_SANDBOX_SUMMARY_HPP
#define TALUS_SANDBOX_SUMMARY_HPP

#include <string>
#include <vector>

#include "config.hpp"
#include "output.hpp"
#include "plan.hpp"

namespace talus::sandbox {

struct StageRecord {
    std::string name;
    std::int64_t steps = 0;
    double time = 0;             // [s] simulated
    double wall_seconds = 0;     // output included
    double stepping_seconds = 0; // inside talus_engine_step
    std::string note;            // e.g. that a kept bed was used
};

struct RunRecord {
    std::string status = "done"; // done, stopped, failed
    std::string error;           // of a failed run
    double wall_seconds = 0;     // from the creation of the engine on
    std::int32_t threads = 1;
    std::int64_t shorten_start_step = 0; // of the engine's clock
    double shorten_start_time = 0;       // [s]
    std::int64_t shorten_steps = 0;
    std::int64_t ghosts = 0;     // at the end, on the rank with most
    std::int64_t peak_bytes = 0; // of resident memory, on the rank with most; 0 if unknown
    std::vector<StageRecord> stages;
    std::vector<SnapshotRecord> snapshots;
};

// The text of summary.json. The engine may be poisoned: what it no longer tells is left out. [collective]
std::string summary_text(const Scene& scene, const Config& config, const Plan& plan, const RunRecord& run);

} // namespace talus::sandbox

#endif
