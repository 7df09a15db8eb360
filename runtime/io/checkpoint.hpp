// runtime/io/checkpoint.hpp: the whole state in one HDF5 file, readable on any number of ranks.
//
//   /                attributes: format, format_version, talus_version, build
//   /state           what every rank holds alike, a small dataset each, units as attributes (state_fields.hpp)
//   /grains          a row a grain: label, position, velocity, ... force and torque sums in units of /state/units, reference
//   /contacts        number: contacts of each grain; partner and history: a row a contact, grain after grain, partners ascending.
//                    Both grains of a pair have a row, with the same bits, so a slab of grains carries all it needs
//   /VTKHDF          soft links and vertices, so that ParaView opens the file under a name that ends in .hdf
//   after the end    the seal (seal.hpp), without which the file counts for nothing
#pragma once

#include <string>

#include "runtime/engine_state.hpp"

namespace talus::runtime {

/// Write the whole state under a temporary name in the same folder and put it in place when it is whole on the disk. A whole
/// checkpoint that stood at `path` is kept as `path`.previous. [collective; every rank throws the same error]
void save_checkpoint(EngineState& s, const std::string& path);

/// Take physics from a checkpoint: s.model (of its settings threads, skin, tile_grains, rebalance, rank_grid and width stay as they
/// are), s.force.pairs, and into s.sub a share of the grains: particles, references, sums, contacts with slot_of, heat, wall sums.
/// Nothing is changed before all has been checked. The caller migrates and rebuilds. [collective; every rank throws the same error]
void load_checkpoint(EngineState& s, const std::string& path);

} // namespace talus::runtime
