// core/packing.hpp: fill a box at random without overlaps: one grain a place of a cubic lattice, its radius and its place in
// the room that the lattice leaves drawn from the place's own random numbers.
#pragma once

#include <cstdint>

#include "core/domain.hpp"

namespace talus::core {

struct FillPlan {
    double lo[3], hi[3]; // m
    double radius_min = 0, radius_max = 0;
    double jitter = 1.0, room = 0.1;
    std::uint64_t seed = 1;
    int layer_axis = 1;        // layers are stacked along it
    bool layers_down = false;  // from the high end
    bool periodic[3] = {false, false, false};

    // derived by plan_lattice
    std::int64_t places[3] = {0, 0, 0};
    double spacing[3] = {0, 0, 0};

    std::int64_t n_places() const { return places[0] * places[1] * places[2]; }
};

struct FilledGrain {
    double position[3];
    double radius;
};

/// Set places and spacing. Surfaces stay inside the box; on periodic axes the lattice closes on itself.
void plan_lattice(FillPlan& plan);

/// The grain of a place, 0 <= place < n_places; places are counted layer by layer.
FilledGrain grain_at(const FillPlan& plan, std::int64_t place);

} // namespace talus::core
