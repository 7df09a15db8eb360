// bed.hpp: beds of grains poured by talus_particles_fill, and what tests ask of them.
#pragma once

#include "engine.hpp"
#include "theory.hpp"

#include <cstdint>

namespace talus::test {

/// SplitMix64: random numbers for initial states that are the same with every standard library.
class Random {
public:
    explicit Random(uint64_t seed) : state_(seed) {}
    /// Uniform in [lo, hi).
    double uniform(double lo, double hi) {
        state_ += 0x9e3779b97f4a7c15ull;
        uint64_t x = state_;
        x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
        x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
        x ^= x >> 31;
        return lo + (hi - lo) * static_cast<double>(x >> 11) * 0x1p-53;
    }
    /// Uniform in the cube [-size, size]^3.
    Vec3 vector(double size) { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }

private:
    uint64_t state_;
};

struct BedScene {
    Solid solid{1.0e7, 0.2, 2600.0};
    double radius_min = 0.9e-3;
    double radius_max = 1.1e-3;
    double width_x = 16.0e-3;
    double width_z = 16.0e-3;
    int64_t grains = 400;
    bool periodic = false; // in x and z; else four side walls
    double restitution = 0.2;
    double friction = 0.0;       // between grains
    double floor_friction = 0.0; // the rest are of the walls
    double side_friction = 0.0;
    double rolling_friction = 0.0;
    talus_laws laws = bare_settings({}, {}, 0.0).laws;
    double step_fraction = 0.15; // of Rayleigh's step of the smallest grain
    double drop_room = 0.1;      // room between the grains of the lattice they fall from, as a share of the diameter
    int32_t energy_ledger = 0;
    uint64_t seed = 1;

    double time_step() const { return step_fraction * solid.rayleigh_step(radius_min); }
    double area() const { return width_x * width_z; }
};

/// An engine with a floor, side walls unless periodic, and grains above the floor that have not fallen yet.
struct Bed {
    Engine engine;
    int32_t grain = 0, floor_material = 1, side_material = 2;
    int32_t floor = 0;
    int32_t sides[4] = {-1, -1, -1, -1}; // x low, x high, z low, z high
    int64_t count = 0;
    double top = 0.0; // of the lattice they fall from

    /// Friction of grains among each other and at walls, from now on.
    void set_friction(const BedScene& scene) {
        engine.contact(grain, grain, scene.restitution, scene.friction, scene.rolling_friction);
        engine.contact(grain, floor_material, scene.restitution, scene.floor_friction, scene.rolling_friction);
        engine.contact(grain, side_material, scene.restitution, scene.side_friction, scene.rolling_friction);
    }
};

inline Bed pour(const BedScene& scene) {
    const double pitch = 2.0 * scene.radius_max * (1.0 + scene.drop_room);
    const auto places = [pitch](double width) { return static_cast<int64_t>(width / pitch); };
    const int64_t per_layer = std::max<int64_t>(1, places(scene.width_x) * places(scene.width_z));
    const double top = pitch * static_cast<double>(scene.grains / per_layer + 2);
    const double margin = scene.periodic ? 0.0 : scene.radius_max;
    talus_settings settings = bare_settings({-margin, -scene.radius_max, -margin},
                                            {scene.width_x + margin, top + scene.radius_max, scene.width_z + margin}, scene.time_step());
    settings.gravity[1] = -9.81;
    settings.periodic[0] = settings.periodic[2] = scene.periodic ? 1 : 0;
    settings.laws = scene.laws;
    settings.energy_ledger = scene.energy_ledger;
    settings.seed = scene.seed;

    Bed bed{Engine(settings)};
    bed.top = top;
    Engine& engine = bed.engine;
    bed.grain = engine.material(scene.solid.young, scene.solid.poisson, scene.solid.density);
    bed.floor_material = engine.material(scene.solid.young, scene.solid.poisson, scene.solid.density);
    bed.side_material = engine.material(scene.solid.young, scene.solid.poisson, scene.solid.density);
    bed.set_friction(scene);
    bed.floor = engine.wall(bed.floor_material, {0.0, 0.0, 0.0}, {0.0, 1.0, 0.0});
    if (!scene.periodic) {
        bed.sides[0] = engine.wall(bed.side_material, {0.0, 0.0, 0.0}, {1.0, 0.0, 0.0});
        bed.sides[1] = engine.wall(bed.side_material, {scene.width_x, 0.0, 0.0}, {-1.0, 0.0, 0.0});
        bed.sides[2] = engine.wall(bed.side_material, {0.0, 0.0, 0.0}, {0.0, 0.0, 1.0});
        bed.sides[3] = engine.wall(bed.side_material, {0.0, 0.0, scene.width_z}, {0.0, 0.0, -1.0});
    }
    bed.count = engine.fill({0.0, 0.0, 0.0}, {scene.width_x, top, scene.width_z}, scene.radius_min, scene.radius_max, scene.grains,
                            bed.grain, scene.drop_room);
    return bed;
}

/// Step until the kinetic energy per grain is below `share` of m g d, or `most_steps`. Returns the steps taken.
inline int64_t settle(Bed& bed, const BedScene& scene, double share, int64_t most_steps) {
    const double radius = 0.5 * (scene.radius_min + scene.radius_max);
    const double limit = share * scene.solid.mass(radius) * 9.81 * 2.0 * radius * static_cast<double>(bed.count);
    const int64_t chunk = 500;
    int64_t taken = 0;
    // The fall starts from rest, which is not rest yet.
    const int64_t least = static_cast<int64_t>(1.5 * std::sqrt(2.0 * bed.top / 9.81) / scene.time_step());
    while (taken < most_steps) {
        bed.engine.step(chunk);
        taken += chunk;
        if (taken >= least && bed.engine.state().kinetic_energy < limit) break;
    }
    return taken;
}

} // namespace talus::test
