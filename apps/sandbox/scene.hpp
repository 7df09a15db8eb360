// scene.hpp: the sandbox of the paper's Fig. 9 as an engine: materials, walls, grains, and the two sets of physics
// (settling without friction, shortening with it). x is the shortening, y is up, z runs along the trench.
#ifndef TALUS_SANDBOX_SCENE_HPP
#define TALUS_SANDBOX_SCENE_HPP

#include <string>
#include <vector>

#include "bed_file.hpp"
#include "config.hpp"
#include "engine.hpp"
#include "plan.hpp"
#include "team.hpp"

namespace talus::sandbox {

struct Wall {
    std::string name;
    std::int32_t id = 0;
    bool is_moving = false; // during shortening
};

struct Scene {
    Engine engine;
    std::vector<Wall> walls; // floor, front, backstop and, unless periodic, side_lo, side_hi; of a column the floor only
};

// All functions are collective.

// The engine with materials and walls, empty, with the physics of settling.
Scene make_scene(const Team& team, const Config& config, const Plan& plan, std::int32_t threads);
// The same from a kept bed; returns false and the reason if it cannot be read.
bool load_scene(const Team& team, const Config& config, const Plan& plan, std::int32_t threads, const std::string& path, Scene& out_scene,
                std::string& out_reason);

// Fill at random up to the planned number of grains.
void fill_box(const Scene& scene, const Config& config, const Plan& plan);
// Insert rank 0's bed.
void insert_bed(const Scene& scene, const Config& config, const Team& team, const Bed& bed);
// Lists, first forces and all checks of the engine that need the grains.
void prepare(const Scene& scene, const Config& config);

// Friction and the laws asked for. Contact histories start from zero.
void switch_friction_on(const Scene& scene, const Config& config);
void set_wall_speed(const Scene& scene, double speed);

} // namespace talus::sandbox

#endif
