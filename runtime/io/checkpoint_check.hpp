// runtime/io/checkpoint_check.hpp: whether what was read can be a state that was saved. Digests have shown by then that the bytes
// are those that were written; this guards against files made by other hands, and against defects of the writer.
#pragma once

#include <string>

#include "core/contact_history.hpp"
#include "runtime/io/columns.hpp"
#include "runtime/io/state_fields.hpp"

namespace talus::runtime {

/// What is wrong with the part that every rank holds, one a line; empty when all is well.
std::string model_faults(const Model& model, const PairTable& pairs);

/// What is wrong with a rank's grains and contacts: the first fault, or empty. [local]
std::string grain_fault(const Model& model, const std::vector<core::Particle>& grains, const std::vector<core::Reference>& references);
std::string contact_fault(const Model& model, const std::vector<core::Particle>& grains, const core::ContactStore& contacts);

/// Labels are given once over all ranks, and both grains of every pair know of it with the same history. Empty on success, else
/// the fault, the same on every rank. [collective]
std::string pairing_fault(Communicator& comm, const std::vector<core::Particle>& grains, const core::ContactStore& contacts);

} // namespace talus::runtime
