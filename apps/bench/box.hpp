// apps/bench/box.hpp: the box of bed and gas.
#pragma once

#include "apps/bench/scene.hpp"

namespace talus::bench {

/// An engine without grains: a floor, a wall at each end of x (numbers 1 and 2), periodic in z, open above; room beyond the walls for
/// grains of `radius_max`. Friction 0.6 between grains, 0.25 at walls, rolling friction 0.05; the time step is yet to be set.
EnginePtr make_box(const SceneOptions& options, const talus_laws& laws, double restitution, const std::array<double, 3>& lo, const std::array<double, 3>& hi, double radius_max);

} // namespace talus::bench
