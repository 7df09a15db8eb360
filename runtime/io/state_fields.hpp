// runtime/io/state_fields.hpp: the part of a checkpoint that every rank holds alike: settings, materials, walls, groups, clock,
// units of the sums, and totals over ranks. One list of names serves writing and reading.
#pragma once

#include <functional>
#include <string>

#include "runtime/io/hdf5_file.hpp"
#include "runtime/model.hpp"

namespace talus::runtime {

using PairTable = core::PairParameters[core::kMaxMaterials][core::kMaxMaterials];

/// Sums over ranks.
struct Totals {
    core::HeatSum heat;
    std::vector<core::WallSum> wall_last;
    std::vector<core::Wide> wall_impulse; // [3 a wall]
};

/// Values are 8 bytes each: f64, i64 or u64.
using FieldSink = std::function<void(const std::string& name, const std::string& unit, Kind, const Shape&, const std::uint64_t* words)>;
using FieldSource = std::function<void(const std::string& name, Kind, const Shape&, std::uint64_t* out_words)>;

/// Give every field to the sink, in a fixed order.
void put_fields(const Model& model, const PairTable& pairs, const Totals& totals, const FieldSink& sink);
/// Take every field from the source, in the same order. Settings that do not touch physics (threads, skin, tile_grains, rebalance,
/// rank_grid, width) stay as they are. Sizes are checked while reading, the rest by model_faults().
void take_fields(const FieldSource& source, Model& model, PairTable& pairs, Totals& totals);

} // namespace talus::runtime
