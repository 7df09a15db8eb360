// runtime/kept_state.hpp: a state of an engine kept in memory, to come back to: implicit coupling tries a step more than once.
//
// It holds what a checkpoint holds (model, grains, sums, contacts with histories, work and heat), each rank its own part; lists, cuts
// and the skin are made anew when it is restored. No bit of the trajectory depends on that.
#pragma once

#include "core/contact_history.hpp"
#include "runtime/engine_state.hpp"

namespace talus::runtime {

class KeptState {
public:
    /// Of an engine with lists and forces, its last step finished. [local]
    explicit KeptState(EngineState& s);
    /// Give it back to the engine it came from, as a loaded checkpoint would stand. [local]
    void restore(EngineState& s) const;

private:
    Model model_;
    core::PairParameters pairs_[core::kMaxMaterials][core::kMaxMaterials];
    std::vector<core::Particle> particles_;
    std::vector<core::Reference> references_;
    std::vector<core::ForceSum> sums_;
    core::ContactStore contacts_;
    core::HeatSum heat_;
    std::vector<core::WallSum> wall_last_;
    std::vector<core::Wide> wall_impulse_;
};

} // namespace talus::runtime
