// The built-in costs: measured once by --calibrate with configs/paper.toml's sand and laws.
#include "costs.hpp"

namespace talus::sandbox {

Costs reference_costs() {
    Costs costs;
    costs.processor = "AMD EPYC (Zen 3)";
    costs.processors = 2;
    costs.grains = 200000;
    costs.contacts_per_grain = 2.9;
    costs.skin_diameters = 0.1;
    costs.history_doubles = 4;
    costs.laws = laws_text(Config::Laws{});
    RunCosts run;
    run.settle = StageCosts{10e6, 100};
    run.shorten = StageCosts{8e6, 100};
    run.busy = {100e-9, 12e-9, 20e-9, 200e-9, 600e-9, 0};
    costs.runs = {run};
    costs.memory = {526, 717, 28e6};
    costs.start_seconds_per_grain = 2e-6;
    costs.write_bytes_per_second = 250e6;
    return costs;
}

} // namespace talus::sandbox
