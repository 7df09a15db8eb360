// plan.hpp: what follows from a configuration: number of grains, box, time step, number of steps (what they take in time and
// memory, forecast.hpp tells). Making it is the second half of validation: whatever does not fit together is added to the faults.
#ifndef TALUS_SANDBOX_PLAN_HPP
#define TALUS_SANDBOX_PLAN_HPP

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "bed_file.hpp"
#include "config.hpp"
#include "faults.hpp"
#include "shortening.hpp"

namespace talus::sandbox {

struct Plan {
    bool has_bed_file = false;
    std::int64_t grains = 0;
    double radius_min = 0, radius_max = 0; // [m] declared to the engine
    double grain_volume = 0;               // [m^3] mean
    double grain_mass = 0;                 // [kg] mean
    std::array<double, 3> lo{};            // [m] the domain; walls stand on its faces
    std::array<double, 3> hi{};
    bool periodic_x = false;  // a column without front wall and back stop, for calibration (sample.hpp)
    double depth = 0;         // [m] of the settled sand
    double fill_top = 0;      // [m] height the loose fill reaches
    double skin = 0;          // [m] there must be room for
    double critical_step = 0; // [s] Rayleigh step of the smallest grain
    double step = 0;          // [s]
    double fall_time = 0;     // [s] free fall of the fill's top: no bed is at rest before
    Shortening shortening;
    std::int64_t shorten_steps = 0;
    bool snapshots_by_time = false;
    double snapshot_every = 0; // [m] of shortening or [s]

    double length() const { return hi[0] - lo[0]; }
    double width() const { return hi[2] - lo[2]; }
    // The snapshot that is due at the n-th multiple of the interval, as a step of the shortening stage.
    std::int64_t snapshot_step(std::int64_t n) const;
    // Steps after which settling is given up.
    std::int64_t settle_cap(const Config& config) const;
};

// The asked-for number of steps (--steps) replaces [shorten] distance. `ranks` > 0 also checks what hangs on them.
Plan make_plan(const Config& config, const std::optional<BedSummary>& bed, std::optional<std::int64_t> steps, int ranks, Faults& faults);

// A few lines that tell the plan.
std::string plan_text(const Config& config, const Plan& plan);

} // namespace talus::sandbox

#endif
