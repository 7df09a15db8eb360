// stages.hpp: the stages of an experiment, as in the paper's section 2.2: settle, switch friction on, shorten. What is
// decided during a stage hangs on step numbers and on values the engine has agreed over all ranks, so that every rank
// takes the same steps.
#ifndef TALUS_SANDBOX_STAGES_HPP
#define TALUS_SANDBOX_STAGES_HPP

#include <string>

#include "input.hpp"
#include "output.hpp"
#include "progress.hpp"
#include "scene.hpp"
#include "summary.hpp"

namespace talus::sandbox {

// How far a bed is from rest, in the measures of [settle].
struct Rest {
    double kinetic = 0;
    double unbalanced = 0;
    bool is_reached = false;
};
Rest rest_of(const Config& config, const Plan& plan, const talus_state& state);

struct Stages {
    const Team& team;
    const Input& input;
    const Scene& scene;
    const OutputFolder& folder;
    Progress& progress;
    Snapshots& snapshots;
    RunRecord& record;

    // Each returns false if a stop was asked for. [collective]

    // Under gravity and without friction until at rest, or to the cap.
    bool settle();
    // Friction and laws, coloured layers, the origin of displacements.
    void switch_friction();
    // Walls against the back stop; time series, snapshots, checkpoints. `trace` is a path or empty.
    bool shorten(const std::string& trace);

private:
    bool advance(std::int64_t steps, StageRecord& stage, const char* doing);
};

} // namespace talus::sandbox

#endif
