#include "core/packing.hpp"

#include <algorithm>
#include <cmath>

#include "core/philox.hpp"

namespace talus::core {

void plan_lattice(FillPlan& plan) {
    const double pitch = 2.0 * plan.radius_max * (1.0 + plan.room);
    for (int a = 0; a < 3; ++a) {
        const double length = plan.hi[a] - plan.lo[a];
        plan.places[a] = std::max<std::int64_t>(0, static_cast<std::int64_t>(std::floor(length / pitch)));
        // Spread evenly across the layers, tightly along them: a bed of a given count then has a given height.
        plan.spacing[a] = a == plan.layer_axis || plan.places[a] == 0 ? pitch : length / static_cast<double>(plan.places[a]);
    }
}

FilledGrain grain_at(const FillPlan& plan, std::int64_t place) {
    const int u = (plan.layer_axis + 1) % 3, v = (plan.layer_axis + 2) % 3;
    std::int64_t at[3];
    at[u] = place % plan.places[u];
    at[v] = place / plan.places[u] % plan.places[v];
    at[plan.layer_axis] = place / (plan.places[u] * plan.places[v]);
    if (plan.layers_down) at[plan.layer_axis] = plan.places[plan.layer_axis] - 1 - at[plan.layer_axis];
    const auto r = random_unit(plan.seed, RandomStream::packing, static_cast<std::uint64_t>(place));
    FilledGrain g;
    g.radius = plan.radius_min + (plan.radius_max - plan.radius_min) * r[3];
    for (int a = 0; a < 3; ++a) {
        const double free = plan.spacing[a] - 2.0 * g.radius;
        const double offset = 0.5 * plan.spacing[a] + plan.jitter * (r[a] - 0.5) * free;
        g.position[a] = plan.lo[a] + static_cast<double>(at[a]) * plan.spacing[a] + offset;
    }
    return g;
}

} // namespace talus::core
