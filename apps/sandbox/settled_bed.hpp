// settled_bed.hpp: the name under which a settled bed is kept. It holds a hash of everything the bed depends on, so
// that a changed configuration settles anew and an unchanged one, or one that differs in friction, speed or output
// only, does not.
#ifndef TALUS_SANDBOX_SETTLED_BED_HPP
#define TALUS_SANDBOX_SETTLED_BED_HPP

#include <string>

#include "config.hpp"
#include "plan.hpp"

namespace talus::sandbox {

// "settled-<16 hex digits>.ckpt"
std::string settled_bed_name(const Config& config, const Plan& plan);

// Equal for beds that settle in the same number of steps, or nearly: extent and seed do not count. 16 hex digits.
std::string settling_key(const Config& config);

} // namespace talus::sandbox

#endif
