// runtime/model.hpp: the part of the state that every rank holds, with the same bits.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/force_kernel.hpp"
#include "core/particles.hpp"
#include "core/skin_choice.hpp"
#include "runtime/settings.hpp"

namespace talus::runtime {

struct Wall {
    core::WallPlane plane;
    core::Vec3d listed_point; // where it was when the lists were built
    double work = 0.0;        // J done on the grains until the velocity or the time step last changed
};

struct Model {
    Settings settings;
    std::vector<core::Material> materials;
    core::ContactMaterial contacts[core::kMaxMaterials][core::kMaxMaterials];
    std::vector<Wall> walls;
    core::GroupTable groups{};
    std::int64_t step = 0;
    double time = 0.0; // s
    // Fixed when the first step is prepared.
    bool units_fixed = false;
    core::FixedUnits units;
    double radius_max = 0.0, radius_min = 0.0; // m, over all grains ever inserted
    std::int64_t n_particles = 0;              // over all ranks

    double skin_share = core::kFirstSkin; // of the largest diameter, for lists with an automatic skin; only a rebuild changes it

    bool automatic_skin() const { return !(settings.skin > 0.0); }
    double diameter() const { return 2.0 * radius_max; }
    double skin() const { return automatic_skin() ? skin_share * diameter() : settings.skin; }
    /// Farthest distance of centres of a listed pair.
    double reach() const { return diameter() + skin(); }
    /// What a run must have room for: an automatic skin counts as at first, so that no refusal depends on the choice.
    double required_reach() const { return diameter() + (automatic_skin() ? core::kFirstSkin * diameter() : settings.skin); }
};

/// The parts of a model that the user sets, and a number for each that differs when a bit does. What only concerns one rank
/// (threads, tiles, kernel width) does not count.
inline constexpr std::array<const char*, 6> kModelParts = {"settings", "laws", "materials", "contacts", "walls", "groups"};
std::array<std::uint64_t, kModelParts.size()> fingerprints(const Model& model);

} // namespace talus::runtime
