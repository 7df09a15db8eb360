#include "shortening.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace talus::sandbox {

Shortening::Shortening(double speed, double ramp, double step) : speed_(speed), ramp_(ramp), step_(step) {}

double Shortening::velocity(std::int64_t step) const {
    const double middle = (static_cast<double>(step - step % kHold) + 0.5 * kHold) * step_;
    if (middle >= ramp_) return speed_;
    const double u = middle / ramp_;
    return speed_ * u * u * (3 - 2 * u);
}

std::int64_t Shortening::next_change(std::int64_t step) const {
    const std::int64_t next = step - step % kHold + kHold;
    const bool is_constant = (static_cast<double>(next) - 0.5 * kHold) * step_ >= ramp_;
    return is_constant ? std::numeric_limits<std::int64_t>::max() : next;
}

double Shortening::travel(std::int64_t step) const {
    const double time = static_cast<double>(step) * step_;
    if (time >= ramp_) return speed_ * (time - 0.5 * ramp_);
    const double u = time / ramp_;
    return speed_ * ramp_ * u * u * u * (1 - 0.5 * u); // the integral of s
}

std::int64_t Shortening::steps_for(double distance) const {
    if (distance <= 0) return 0;
    // travel() grows with the step; an upper bound is the time at full speed after the whole ramp.
    std::int64_t low = 0;
    auto high = static_cast<std::int64_t>(std::ceil((ramp_ + distance / speed_) / step_)) + 1;
    while (high - low > 1) {
        const std::int64_t middle = low + (high - low) / 2;
        (travel(middle) >= distance ? high : low) = middle;
    }
    return high;
}

} // namespace talus::sandbox
