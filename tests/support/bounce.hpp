// bounce.hpp: many grains, far apart, each hitting one rigid floor (y = 0) once, without gravity.
// One engine holds them all, so a sweep over speeds, angles and spins costs one run.
#pragma once

#include "engine.hpp"
#include "theory.hpp"

namespace talus::test {

/// What grain and floor do in touch; each kind is a material of its own (at most 15).
struct BounceKind {
    double restitution = 1.0;
    double friction = 0.0;
};

struct Launch {
    Vec3 velocity{}; // velocity[1] < 0
    Vec3 spin{};
    int32_t kind = 0;
    /// Way to the floor at the start, in steps of the grain; its fraction is the phase at which the contact is first seen.
    double steps_to_floor = 1.5;
};

struct Landing {
    Vec3 velocity{};
    Vec3 spin{};
};

struct BounceScene {
    Solid solid = kSand;
    double radius = kSandRadius;
    talus_laws laws = bare_settings({}, {}, 0.0).laws;
    std::vector<BounceKind> kinds{BounceKind{}};
    std::vector<Launch> launches;
    double time_step = 0.0;
};

/// Kinetic energy per mass of a sphere.
inline double energy_per_mass(const Vec3& velocity, const Vec3& spin, double radius) {
    return 0.5 * dot(velocity, velocity) + 0.2 * radius * radius * dot(spin, spin);
}

/// Run until every grain has left the floor. A grain has left once it rises and no force acts on it: a clipped contact
/// no longer changes the grain although the overlap takes longer to open.
inline std::vector<Landing> bounce(const BounceScene& scene) {
    const double radius = scene.radius;
    const HertzPair pair = HertzPair::on_rigid_wall(scene.solid, radius);
    double longest = 0.0;
    double fastest_x = 0.0;
    double fastest_z = 0.0;
    for (const Launch& launch : scene.launches) {
        const double hertz = pair.duration(-launch.velocity[1]);
        const double linear = scene.laws.stiffness_n > 0.0 ? kPi * std::sqrt(pair.mass / scene.laws.stiffness_n) : 0.0;
        longest = std::max({longest, hertz, linear});
        fastest_x = std::max(fastest_x, std::fabs(launch.velocity[0]));
        fastest_z = std::max(fastest_z, std::fabs(launch.velocity[2]));
    }
    const int64_t chunk = std::max<int64_t>(1, static_cast<int64_t>(0.25 * longest / scene.time_step));
    const int64_t most_chunks = 100; // overdamped contacts at e = 0.05 take some ten durations

    // Friction may turn a fast spin into sideways motion of up to (1 + e) mu times the normal speed, hence the margin.
    const double reach_x = 20.0 * longest * fastest_x + 6.0 * radius;
    const double lane = 40.0 * longest * fastest_z + 6.0 * radius;
    const double length = lane * static_cast<double>(scene.launches.size());
    talus_settings settings = bare_settings({-reach_x, -radius, -lane}, {reach_x, 40.0 * radius, length}, scene.time_step);
    settings.laws = scene.laws;
    Engine engine(settings);
    const int32_t floor = engine.rigid_material();
    for (const BounceKind& kind : scene.kinds) {
        const int32_t id = engine.material(scene.solid.young, scene.solid.poisson, scene.solid.density);
        engine.contact(floor, id, kind.restitution, kind.friction);
        for (int32_t other = floor + 1; other <= id; ++other) engine.contact(other, id, 1.0, 0.0);
    }
    engine.wall(floor, {0.0, 0.0, 0.0}, {0.0, 1.0, 0.0});
    std::vector<Grain> grains;
    for (std::size_t i = 0; i < scene.launches.size(); ++i) {
        const Launch& launch = scene.launches[i];
        const double height = radius - launch.velocity[1] * scene.time_step * launch.steps_to_floor;
        grains.push_back({{0.0, height, lane * static_cast<double>(i)}, radius, launch.velocity, launch.spin, floor + 1 + launch.kind, 0});
    }
    engine.insert(grains);

    const std::size_t n = grains.size();
    std::vector<Landing> landings(n);
    bool all_left = false;
    for (int64_t i = 0; i < most_chunks && !all_left; ++i) {
        engine.step(chunk);
        const auto velocities = engine.velocities();
        const auto spins = engine.spins();
        const auto forces = engine.forces();
        all_left = true;
        for (std::size_t k = 0; k < n; ++k) {
            landings[k] = {velocities[k], spins[k]};
            all_left = all_left && velocities[k][1] > 0.0 && forces[k] == Vec3{};
        }
    }
    if (!all_left) throw std::runtime_error("a grain never left the floor");
    return landings;
}

} // namespace talus::test
