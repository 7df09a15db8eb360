// shortening.hpp: when the walls move how fast. All of it is a function of the step number, never of how the steps are
// grouped into calls, so that a run has the same bits however it is watched, stopped or resumed.
//
// The speed rises as v s(u), s(u) = u^2 (3 - 2u), u = t/T: no jump in velocity or acceleration at either end, and an
// acceleration of at most 1.5 v/T. It is held constant over kHold steps and set to the value at their middle.
#ifndef TALUS_SANDBOX_SHORTENING_HPP
#define TALUS_SANDBOX_SHORTENING_HPP

#include <cstdint>

namespace talus::sandbox {

class Shortening {
public:
    static constexpr std::int64_t kHold = 10;

    Shortening() = default;
    // @param speed [m/s]  @param ramp [s] >= 0, 0: full speed from the first step  @param step [s]
    Shortening(double speed, double ramp, double step);

    double speed() const { return speed_; }
    double ramp() const { return ramp_; }

    // [m/s] during step number `step` (0 is the first)
    double velocity(std::int64_t step) const;
    // The first step after `step` at which the velocity may differ; a very large number once it is constant.
    std::int64_t next_change(std::int64_t step) const;
    // [m] gone by the front wall before step number `step`
    double travel(std::int64_t step) const;
    // The least number of steps in which the wall goes at least `distance` [m].
    std::int64_t steps_for(double distance) const;

private:
    double speed_ = 0;
    double ramp_ = 0;
    double step_ = 1;
};

} // namespace talus::sandbox

#endif
