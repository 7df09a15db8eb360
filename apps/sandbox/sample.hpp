// sample.hpp: the grains that calibration steps, a settled piece of the experiment of some 200,000 grains: lists, sums and histories
// then do not fit into caches, as in a real run. Of a bed file it is a slice behind the front wall. Else a column of the same
// sand and depth, some grains wide and periodic along x and z, is filled and settled as the experiment would be, and the sample
// is as many copies of it, side by side, as it takes. Where the sample was cut off along x its outermost grains are held.
#ifndef TALUS_SANDBOX_SAMPLE_HPP
#define TALUS_SANDBOX_SAMPLE_HPP

#include <functional>
#include <optional>
#include <string>

#include "costs.hpp"
#include "input.hpp"
#include "scene.hpp"

namespace talus::sandbox {

struct Sample {
    Config config;
    Plan plan; // of the sample alone: its box and number of grains
    Bed bed;   // on rank 0

    struct Column {
        Settling settling;
        double speed = 0;         // [particle-steps/s] from the fill to the end of settling
        double speed_at_rest = 0; // ... and of the settled column, still without friction
    };
    std::optional<Column> column; // on rank 0, without a bed file

    // The experiment's two sets of physics.
    Plan settling_plan() const;
    Plan shortening_plan() const;
};

// The grains that stand for what was cut off in front move at `speed` [m/s], those at the back stay. [collective]
void set_faces(const Scene& scene, double speed);

// @param tell  called on rank 0 with what is being done
// [collective]
Sample make_sample(const Team& team, const Input& input, const std::function<void(const std::string&)>& tell);

} // namespace talus::sandbox

#endif
