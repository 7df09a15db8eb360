// small_world.hpp: the scene of the tests of single functions of the ABI.
#pragma once

#include "scenes.hpp"

namespace talus::test {

/// A box with two layers of grains on a floor, ready to step.
inline World small_world(const HowToRun& run = {}) {
    talus_settings s = scene_settings({-0.001, -0.001, -0.001}, {0.013, 0.02, 0.013}, run);
    World world(s, run.comm);
    const int32_t sand = world.material(kSceneSand);
    world.contact(sand, sand, 0.5, 0.5, 0.1);
    world.wall(sand, {0, 0, 0}, {0, 1, 0}, {0.2, 0, 0});
    world.insert(lattice(6, 2, 6, {0, 0, 0}, 0.02, 0.05), 0.1);
    return world;
}
inline std::array<uint64_t, 2> digest(World& w) {
    const talus_state s = w.state();
    return {s.digest_hi, s.digest_lo};
}

} // namespace talus::test
