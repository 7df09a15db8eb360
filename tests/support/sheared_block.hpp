// sheared_block.hpp: a block of grains between two walls on a floor that moves, periodic in z, for tests of speed: large enough that a
// step is work, with contacts from its first step.
#pragma once

#include "scenes.hpp"

namespace talus::test {

/// @param n  grains along x, y and z, one mean diameter apart
inline World make_sheared_block(const std::array<int, 3>& n, double floor_speed, const HowToRun& run) {
    const double d = 2.0 * kSceneRadius;
    const Vec3 size{n[0] * d, n[1] * d, n[2] * d};
    talus_settings s = scene_settings({-d, -d, 0.0}, {size[0] + d, 3.0 * size[1] + d, size[2]}, run);
    s.periodic[2] = 1;
    World world(s, run.comm);
    const int32_t sand = world.material(kSceneSand);
    world.contact(sand, sand, 0.2, 0.6, 0.05);
    world.wall(sand, {0, 0, 0}, {0, 1, 0}, {floor_speed, 0, 0});
    world.wall(sand, {0, 3.0 * size[1], 0}, {0, -1, 0});
    world.wall(sand, {0, 0, 0}, {1, 0, 0});
    world.wall(sand, {size[0], 0, 0}, {-1, 0, 0});
    world.insert(lattice(n[0], n[1], n[2], {0, 0, 0}, 0.02, 0.05), 0.1);
    return world;
}

} // namespace talus::test
