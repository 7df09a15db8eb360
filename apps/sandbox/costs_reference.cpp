// The built-in costs: medians of what --calibrate found for configs/paper.toml with one thread on a virtual machine of two processors
// that it shared with other work. Memory is such that a bed of two million grains has 526 bytes a grain beside the base, as many when it is saved.
#include "costs.hpp"

namespace talus::sandbox {

Costs reference_costs() {
    Costs costs;
    costs.processor = "AMD EPYC (AVX2)";
    costs.processors = 2;
    costs.grains = 209720;
    costs.contacts_per_grain = 2.97;
    costs.skin_diameters = 0.1;
    costs.history_doubles = history_doubles(Config::Laws{});
    costs.laws = laws_text(Config::Laws{});
    RunCosts run;
    run.settle = StageCosts{11.4e6, 80};
    run.shorten = StageCosts{7.9e6, 92};
    run.busy = {102e-9, 22e-9, 34e-9, 150e-9, 590e-9, 80e-9};
    run.idle_share = 0.03;
    costs.runs = {run};
    costs.memory = {588, 588, 28e6, false};
    costs.start_seconds_per_grain = 1.3e-6;
    costs.write_bytes_per_second = 380e6;
    return costs;
}

} // namespace talus::sandbox
