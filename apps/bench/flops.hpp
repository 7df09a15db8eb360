// apps/bench/flops.hpp: operations of the force phase, counted by running its templates on a number that counts (counted.hpp).
#pragma once

#include <string>
#include <vector>

#include "apps/bench/counted.hpp"
#include "runtime/engine_state.hpp"

namespace talus::bench {

/// One contact of grains taken through geometry and law, part by part.
struct LawOperations {
    Operations candidate; // is it a contact?
    struct Part {
        std::string name;
        Operations operations;
    };
    std::vector<Part> parts;

    Operations contact() const;
};
LawOperations count_law(const core::Laws& laws);

/// One evaluation of all forces of an engine of one rank whose lists stand, filters and conversion to integers with it. Sums
/// come out as of a new evaluation where grains stand; histories are not advanced. One engine at a time.
struct ForceOperations {
    Operations pairs, walls;
};
ForceOperations count_forces(runtime::EngineState& state);

} // namespace talus::bench
