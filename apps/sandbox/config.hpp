// config.hpp: everything a user can set, typed, in SI units, with the paper's Table 1 as default. The key table in
// config_keys.cpp binds each member to its name in the TOML file and documents it.
#ifndef TALUS_SANDBOX_CONFIG_HPP
#define TALUS_SANDBOX_CONFIG_HPP

#include <talus.h>

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>

namespace talus::sandbox {

constexpr std::int32_t kStartRamp = 0;     // walls speed up smoothly, slowly enough for friction to carry the sand
constexpr std::int32_t kStartCoMoving = 1; // walls and sand have full speed from the first step
constexpr std::int32_t kStartAtOnce = 2;   // walls have full speed from the first step, the sand is at rest

struct Config {
    struct Run {
        std::int64_t seed = 1;
        std::optional<std::int64_t> threads;
        std::optional<double> snapshot_shortening;
        std::optional<double> snapshot_time;
        std::int64_t walls_every = 100;
        bool checkpoint = true;
        std::int64_t checkpoint_every = 0;
    } run;

    struct Sand {
        double diameter_mean = 227.5e-6;
        double diameter_half_width = 22.5e-6;
        double density = 2600;
        double young = 1e7;
        double poisson = 0.2;
        double friction = 0.6;
        double restitution = 0.2;
        double rolling_friction = 0.05;
    } sand;

    struct Box {
        double length = 1;
        double depth = 0.0188;
        double width = 1;
        std::optional<double> height;
        bool periodic_z = false;
        double gravity = 9.81;
        double solid_fraction = 0.63;
        double fill_room = 0.1;
        bool level = false;
    } box;

    struct Walls {
        double floor_friction = 0.25;
        double front_friction = 0.25;
        double backstop_friction = 0.25;
        double side_friction = 0;
        std::optional<double> restitution;
        std::optional<double> rolling_friction;
        bool rigid = false;
        std::optional<double> young;
        std::optional<double> poisson;
    } walls;

    struct Laws {
        std::int32_t normal = TALUS_NORMAL_HERTZ;
        std::int32_t damping = TALUS_DAMPING_CLIPPED;
        std::int32_t tangential = TALUS_TANGENTIAL_FORCE_RESCALED;
        bool tangential_damping = true;
        std::int32_t rolling = TALUS_ROLLING_CONSTANT;
        std::int32_t rolling_radius = TALUS_ROLLING_RADIUS_EFFECTIVE;
        double rolling_rate = 1e-3;
        double rolling_damping = 0.3;
        std::optional<double> stiffness_n;
        std::optional<double> stiffness_t;
    } laws;

    struct Time {
        double step_fraction = 0.15;
        std::optional<double> step;
    } time;

    struct Settle {
        double kinetic = 1e-5;
        double unbalanced = 1e-2;
        std::int64_t check_every = 200;
        double cap = 1;
        std::optional<double> restitution;
        bool keep = true;
        std::string bed_cache;
    } settle;

    struct Shorten {
        double speed = 0.1;
        std::optional<double> distance;
        std::optional<double> duration;
        std::int32_t start = kStartRamp;
        std::optional<double> ramp;
        struct Moving {
            bool floor = true;
            bool front = true;
            bool sides = true;
        } moving;
    } shorten;

    struct Layers {
        double thickness = 0.00235;
    } layers;

    struct Bed {
        std::string file;
        std::string axes = "xyz";
        double max_overlap = 0.05;
    } bed;

    struct Engine {
        double skin = 0;
        std::int64_t tile_grains = 0;
        std::int32_t rebalance = TALUS_REBALANCE_AUTO;
        std::int64_t rebalance_interval = 1;
        std::array<std::int64_t, 3> rank_grid{0, 0, 0};
        bool energy_ledger = false;
    } engine;

    // Where a key was set, and the text of its value there; for messages.
    struct Given {
        std::string where; // file:line:column, or --set
        std::string value;
    };
    std::map<std::string, Given> given;
    std::set<std::string> refused; // keys whose value was faulty: they keep their default, and no conclusion is drawn
    std::string source;            // the configuration file's path as the user wrote it

    bool is_given(const std::string& path) const { return given.count(path) != 0; }
};

} // namespace talus::sandbox

#endif
