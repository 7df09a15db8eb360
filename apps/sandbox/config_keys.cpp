#include "config_keys.hpp"

#include <fmt/format.h>

namespace talus::sandbox {

#define TALUS_SLOT(member) [](Config& c) -> Slot { return &c.member; }

namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kMostSteps = 1e12;

// Ranges. Lengths and stiffnesses are bounded on both sides: what lies outside is a wrong unit, not a sandbox.
constexpr Range kGrainSize{1e-6, 1, false, false};
constexpr Range kLength{1e-4, 100, false, false};
constexpr Range kFriction{0, 10, false, false};
constexpr Range kRestitution{0.05, 1, false, false};
constexpr Range kYoung{1e3, 1e13, false, false};
constexpr Range kPoisson{0, 0.5, false, true};
constexpr Range kAboveZero{0, kInf, true, true};
constexpr Range kFromZero{0, kInf, false, true};
constexpr Range kSteps{1, kMostSteps, false, false};
constexpr Range kAny{};

// A key is table, name, unit, meaning, slot, range, effect, words, and what it means to leave it out.
// clang-format off
std::vector<Key> run_keys() {
    return {
        {"run", "seed", "1", "random numbers of the fill", TALUS_SLOT(run.seed), {0, 9e15}, Effect::kSettledBed, {}},
        {"run", "threads", "1", "worker threads of each rank", TALUS_SLOT(run.threads), {1, 4096}, {}, {},
         "the processors of the machine shared among its ranks"},
        {"run", "snapshot_shortening", "m", "a snapshot each time the front wall has gone this far",
         TALUS_SLOT(run.snapshot_shortening), kAboveZero, {}, {}, "0.002, if snapshot_time is not given either"},
        {"run", "snapshot_time", "s", "a snapshot each time this much time has passed; instead of snapshot_shortening",
         TALUS_SLOT(run.snapshot_time), kAboveZero, {}, {}, "snapshot_shortening counts"},
        {"run", "walls_every", "steps", "a row in walls.csv every so many steps", TALUS_SLOT(run.walls_every), kSteps},
        {"run", "checkpoint", "", "write run.ckpt at the end", TALUS_SLOT(run.checkpoint), kAny},
        {"run", "checkpoint_every", "steps", "and during shortening every so many steps; 0: only at the end",
         TALUS_SLOT(run.checkpoint_every), {0, kMostSteps}},
    };
}

std::vector<Key> sand_keys() {
    constexpr Effect bed = Effect::kSettledBed;
    return {
        {"sand", "diameter_mean", "m", "mean grain diameter", TALUS_SLOT(sand.diameter_mean), kGrainSize, bed},
        {"sand", "diameter_half_width", "m", "diameters are uniform within mean +- this",
         TALUS_SLOT(sand.diameter_half_width), {0, 1}, bed},
        {"sand", "density", "kg/m^3", "of the grain, without pores", TALUS_SLOT(sand.density), {1, 1e5}, bed},
        {"sand", "young", "Pa", "Young's modulus", TALUS_SLOT(sand.young), kYoung, bed},
        {"sand", "poisson", "1", "Poisson's ratio", TALUS_SLOT(sand.poisson), kPoisson, bed},
        {"sand", "friction", "1", "Coulomb friction between grains", TALUS_SLOT(sand.friction), kFriction},
        {"sand", "restitution", "1", "coefficient of restitution", TALUS_SLOT(sand.restitution), kRestitution, bed},
        {"sand", "rolling_friction", "1", "coefficient of rolling friction", TALUS_SLOT(sand.rolling_friction), kFriction},
    };
}

std::vector<Key> box_keys() {
    constexpr Effect bed = Effect::kSettledBed;
    return {
        {"box", "length", "m", "along x, from the front wall to the back stop", TALUS_SLOT(box.length), kLength, bed},
        {"box", "depth", "m", "of the settled sand, along y", TALUS_SLOT(box.depth), {1e-4, 10}, bed},
        {"box", "width", "m", "along z, the trench", TALUS_SLOT(box.width), kLength, bed},
        {"box", "height", "m", "of the space for filling and uplift; a grain that rises above it ends the run",
         TALUS_SLOT(box.height), kLength, bed, {}, "room for the fill, for 4 depths and for the wedge"},
        {"box", "periodic_z", "", "no side walls: z = 0 and z = width are one", TALUS_SLOT(box.periodic_z), kAny, bed},
        {"box", "gravity", "m/s^2", "downwards, along -y", TALUS_SLOT(box.gravity), {1e-3, 1e4}, bed},
        {"box", "solid_fraction", "1", "of the settled sand, by which grains are counted for the depth",
         TALUS_SLOT(box.solid_fraction), {0.3, 0.74}, bed},
        {"box", "fill_room", "1", "room between grains at the fill, as a share of the largest diameter",
         TALUS_SLOT(box.fill_room), {0, 10}, bed},
        {"box", "level", "", "after settling, take away what sticks out above the depth", TALUS_SLOT(box.level), kAny, bed},
    };
}

std::vector<Key> wall_keys() {
    constexpr Effect bed = Effect::kSettledBed;
    return {
        {"walls", "floor_friction", "1", "sand on the floor", TALUS_SLOT(walls.floor_friction), kFriction},
        {"walls", "front_friction", "1", "sand on the front wall", TALUS_SLOT(walls.front_friction), kFriction},
        {"walls", "backstop_friction", "1", "sand on the back stop", TALUS_SLOT(walls.backstop_friction), kFriction},
        {"walls", "side_friction", "1", "sand on both side walls", TALUS_SLOT(walls.side_friction), kFriction},
        {"walls", "restitution", "1", "of sand on walls", TALUS_SLOT(walls.restitution), kRestitution, bed, {},
         "that of the sand"},
        {"walls", "rolling_friction", "1", "of sand on walls", TALUS_SLOT(walls.rolling_friction), kFriction, {}, {},
         "that of the sand"},
        {"walls", "rigid", "", "walls do not yield", TALUS_SLOT(walls.rigid), kAny, bed},
        {"walls", "young", "Pa", "Young's modulus of walls", TALUS_SLOT(walls.young), kYoung, bed, {}, "that of the sand"},
        {"walls", "poisson", "1", "Poisson's ratio of walls", TALUS_SLOT(walls.poisson), kPoisson, bed, {},
         "that of the sand"},
    };
}

std::vector<Key> law_keys() {
    constexpr Effect bed = Effect::kSettledBed;
    return {
        {"laws", "normal", "", "normal force", TALUS_SLOT(laws.normal), kAny, bed,
         {{"hertz", TALUS_NORMAL_HERTZ}, {"linear", TALUS_NORMAL_LINEAR}}},
        {"laws", "damping", "", "clipped: never attracts, and gives the restitution asked for; attractive: as LAMMPS",
         TALUS_SLOT(laws.damping), kAny, bed,
         {{"clipped", TALUS_DAMPING_CLIPPED}, {"attractive", TALUS_DAMPING_ATTRACTIVE}}},
        {"laws", "tangential", "", "history of the tangential force", TALUS_SLOT(laws.tangential), kAny, {},
         {{"force-rescaled", TALUS_TANGENTIAL_FORCE_RESCALED}, {"force", TALUS_TANGENTIAL_FORCE},
          {"displacement", TALUS_TANGENTIAL_DISPLACEMENT}, {"none", TALUS_TANGENTIAL_NONE}}},
        {"laws", "tangential_damping", "", "damp tangential motion too", TALUS_SLOT(laws.tangential_damping), kAny},
        {"laws", "rolling", "", "constant: type A, constant torque; spring: type C, elastic-plastic",
         TALUS_SLOT(laws.rolling), kAny, {},
         {{"constant", TALUS_ROLLING_CONSTANT}, {"spring", TALUS_ROLLING_SPRING}, {"none", TALUS_ROLLING_NONE}}},
        {"laws", "rolling_radius", "", "effective: R* = Ri Rj/(Ri + Rj); own: each grain's (type A only)",
         TALUS_SLOT(laws.rolling_radius), kAny, {},
         {{"effective", TALUS_ROLLING_RADIUS_EFFECTIVE}, {"own", TALUS_ROLLING_RADIUS_OWN}}},
        {"laws", "rolling_rate", "rad/s", "type A: the torque falls to zero below this rate",
         TALUS_SLOT(laws.rolling_rate), kAboveZero},
        {"laws", "rolling_damping", "1", "type C: fraction of critical damping", TALUS_SLOT(laws.rolling_damping), kFromZero},
        {"laws", "stiffness_n", "N/m", "linear law: normal stiffness", TALUS_SLOT(laws.stiffness_n), kAboveZero, bed, {},
         "an error with the linear law"},
        {"laws", "stiffness_t", "N/m", "linear law: tangential stiffness", TALUS_SLOT(laws.stiffness_t), kAboveZero, {},
         {}, "2/7 of stiffness_n"},
    };
}

std::vector<Key> stage_keys() {
    constexpr Effect bed = Effect::kSettledBed;
    return {
        {"time", "step_fraction", "1", "time step as a fraction of the Rayleigh step of the smallest grain",
         TALUS_SLOT(time.step_fraction), {0, 0.5, true}, bed},
        {"time", "step", "s", "time step; instead of step_fraction", TALUS_SLOT(time.step), kAboveZero, bed, {},
         "step_fraction counts"},
        {"settle", "kinetic", "1", "at rest when kinetic energy is below this times m g d a grain",
         TALUS_SLOT(settle.kinetic), kAboveZero, bed},
        {"settle", "unbalanced", "1", "... and mean net force below this times the mean contact force",
         TALUS_SLOT(settle.unbalanced), kAboveZero, bed},
        {"settle", "check_every", "steps", "look every so many steps", TALUS_SLOT(settle.check_every), kSteps, bed},
        {"settle", "cap", "s", "go on after this simulated time even if not at rest", TALUS_SLOT(settle.cap), kFromZero, bed},
        {"settle", "restitution", "1", "coefficient of restitution while settling", TALUS_SLOT(settle.restitution),
         kRestitution, bed, {}, "that of the sand"},
        {"settle", "keep", "", "keep the settled bed, and use it again when nothing it depends on has changed",
         TALUS_SLOT(settle.keep), kAny},
        {"settle", "bed_cache", "", "folder for kept beds", TALUS_SLOT(settle.bed_cache), kAny, {}, {}, "the output folder"},
        {"shorten", "speed", "m/s", "of the walls, along +x", TALUS_SLOT(shorten.speed), {0, 100, true}},
        {"shorten", "distance", "m", "the front wall goes in all", TALUS_SLOT(shorten.distance), kFromZero, {}, {},
         "half the length, if duration is not given either"},
        {"shorten", "duration", "s", "of the stage, ramp included; instead of distance", TALUS_SLOT(shorten.duration),
         kFromZero, {}, {}, "distance counts"},
        {"shorten", "start", "",
         "ramp: walls speed up smoothly; co-moving: walls and sand at full speed; at-once: walls only",
         TALUS_SLOT(shorten.start), kAny, {},
         {{"ramp", kStartRamp}, {"co-moving", kStartCoMoving}, {"at-once", kStartAtOnce}}},
        {"shorten", "ramp", "s", "time in which the speed rises", TALUS_SLOT(shorten.ramp), kFromZero, {}, {},
         "3 speed/(floor_friction gravity): at most half of what floor friction can carry"},
        {"shorten", "moving", "", "walls that move: any of floor, front, sides", TALUS_SLOT(shorten.moving), kAny},
        {"layers", "thickness", "m", "of the coloured stripes", TALUS_SLOT(layers.thickness), kAboveZero},
    };
}

std::vector<Key> other_keys() {
    return {
        {"bed", "file", "", "start from this settled bed (text or HDF5) instead of filling and settling; relative to "
         "this file, or to the working folder with --set", TALUS_SLOT(bed.file), kAny, {}, {}, "fill and settle"},
        {"bed", "axes", "", "the file's axes that become x, y (up) and z; xzy for a file with z up", TALUS_SLOT(bed.axes),
         kAny},
        {"bed", "max_overlap", "1", "refuse a bed with a larger overlap, as a share of the smaller radius",
         TALUS_SLOT(bed.max_overlap), {0, 1, true}},
        {"engine", "skin", "m", "reach of the candidate list beyond touch, 0: chosen from the motion while running; "
         "changes no bits", TALUS_SLOT(engine.skin), kFromZero},
        {"engine", "tile_grains", "1", "grains aimed at in a tile, 0: chosen; changes no bits",
         TALUS_SLOT(engine.tile_grains), {0, 1e9}},
        {"engine", "rebalance", "", "moving of subdomain cuts; changes no bits", TALUS_SLOT(engine.rebalance), kAny, {},
         {{"auto", TALUS_REBALANCE_AUTO}, {"off", TALUS_REBALANCE_OFF}, {"every", TALUS_REBALANCE_EVERY},
          {"random", TALUS_REBALANCE_RANDOM}}},
        {"engine", "rebalance_interval", "1", "rebuilds between two moves of cuts, with rebalance = \"every\" or \"random\"",
         TALUS_SLOT(engine.rebalance_interval), {1, 1e9}},
        {"engine", "rank_grid", "1", "subdomains along x, y, z, 0: chosen; changes no bits", TALUS_SLOT(engine.rank_grid),
         {0, 1e6}},
        {"engine", "energy_ledger", "", "account dissipated energy every step, and write energy.csv",
         TALUS_SLOT(engine.energy_ledger), kAny, Effect::kSettledBed},
    };
}

// clang-format on

} // namespace

const std::vector<Key>& config_keys() {
    static const std::vector<Key> keys = [] {
        std::vector<Key> all;
        for (auto&& part : {run_keys(), sand_keys(), box_keys(), wall_keys(), law_keys(), stage_keys(), other_keys()})
            all.insert(all.end(), part.begin(), part.end());
        return all;
    }();
    return keys;
}

const Key* find_key(const std::string& path) {
    for (const Key& key : config_keys())
        if (key.path() == path) return &key;
    return nullptr;
}

} // namespace talus::sandbox
