// runtime/io/snapshot.hpp: a picture of the grains for ParaView and for scripts.
//
//   /VTKHDF                UnstructuredGrid 1.0, one vertex a grain, one part a rank
//   PointData              label int64, radius [m] float32, velocity [m/s] float32 x 3, displacement [m] float32 x 3,
//                          colour int32, owner (rank) int32; Points are float64
//   attributes of /        box_lo, box_hi [m], periodic (0 or 1 an axis), time [s], step
#pragma once

#include <string>

#include "runtime/engine_state.hpp"

namespace talus::runtime {

/// Write a snapshot; what stood at `path` is replaced when the new one is whole. [collective; every rank throws the same error]
void write_snapshot(EngineState& s, const std::string& path);

} // namespace talus::runtime
