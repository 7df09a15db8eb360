#include "scene.hpp"

#include <fmt/format.h>

namespace talus::sandbox {

namespace {

// Material ids, in the order of insertion. Each kind of wall is a material of its own to have its own friction.
enum Material : std::int32_t { kSand, kFloor, kFront, kBackstop, kSides };

talus_laws laws_of(const Config& config) {
    const Config::Laws& in = config.laws;
    talus_laws laws;
    talus_laws_init(&laws);
    laws.normal = in.normal;
    laws.damping = in.damping;
    laws.tangential = in.tangential;
    laws.tangential_damping = in.tangential_damping ? 1 : 0;
    laws.rolling = in.rolling;
    laws.rolling_radius = in.rolling_radius;
    laws.rolling_rate = in.rolling_rate;
    laws.rolling_damping = in.rolling_damping;
    laws.stiffness_n = in.stiffness_n.value_or(laws.stiffness_n);
    laws.stiffness_t = in.stiffness_t.value_or(laws.stiffness_t);
    return laws;
}

talus_laws settling_laws_of(const Config& config) {
    talus_laws laws = laws_of(config);
    laws.tangential = TALUS_TANGENTIAL_NONE;
    laws.rolling = TALUS_ROLLING_NONE;
    laws.rolling_radius = TALUS_ROLLING_RADIUS_EFFECTIVE;
    return laws;
}

talus_settings settings_of(const Config& config, const Plan& plan, std::int32_t threads) {
    talus_settings settings;
    talus_settings_init(&settings);
    for (int axis = 0; axis < 3; ++axis) {
        settings.domain_lo[axis] = plan.lo[axis];
        settings.domain_hi[axis] = plan.hi[axis];
        settings.rank_grid[axis] = static_cast<std::int32_t>(config.engine.rank_grid[axis]);
    }
    settings.periodic[0] = plan.periodic_x ? 1 : 0;
    settings.periodic[2] = config.box.periodic_z ? 1 : 0;
    settings.threads = threads;
    settings.gravity[0] = settings.gravity[2] = 0;
    settings.gravity[1] = -config.box.gravity;
    settings.time_step = plan.step;
    settings.skin = config.engine.skin;
    settings.radius_max = plan.radius_max;
    settings.tile_grains = static_cast<std::int32_t>(config.engine.tile_grains);
    settings.rebalance = config.engine.rebalance;
    settings.rebalance_interval = static_cast<std::int32_t>(config.engine.rebalance_interval);
    settings.energy_ledger = config.engine.energy_ledger ? 1 : 0;
    settings.seed = static_cast<std::uint64_t>(config.run.seed);
    settings.laws = plan.has_bed_file ? laws_of(config) : settling_laws_of(config);
    return settings;
}

std::vector<Wall> walls_of(const Config& config, const Plan& plan) {
    const Config::Shorten::Moving& moving = config.shorten.moving;
    std::vector<Wall> walls{{"floor", 0, moving.floor}};
    if (plan.periodic_x) return walls;
    walls.push_back({"front", 1, moving.front});
    walls.push_back({"backstop", 2, false});
    if (!config.box.periodic_z) {
        walls.push_back({"side_lo", 3, moving.sides});
        walls.push_back({"side_hi", 4, moving.sides});
    }
    return walls;
}

// What sand does on sand and on each wall. Without friction while settling.
void set_contacts(const Engine& engine, const Config& config, bool has_friction) {
    const Config::Sand& sand = config.sand;
    const Config::Walls& walls = config.walls;
    const double friction[] = {sand.friction, walls.floor_friction, walls.front_friction, walls.backstop_friction, walls.side_friction};
    for (const std::int32_t other : {kSand, kFloor, kFront, kBackstop, kSides}) {
        talus_contact contact;
        talus_contact_init(&contact);
        contact.restitution = other == kSand ? sand.restitution : walls.restitution.value_or(sand.restitution);
        if (!has_friction) contact.restitution = config.settle.restitution.value_or(contact.restitution);
        contact.friction = has_friction ? friction[other] : 0;
        contact.rolling_friction =
            !has_friction ? 0 : (other == kSand ? sand.rolling_friction : walls.rolling_friction.value_or(sand.rolling_friction));
        engine.check(talus_contact_set(engine.get(), kSand, other, &contact), "setting contacts");
    }
}

void add_materials(const Engine& engine, const Config& config) {
    for (const std::int32_t id : {kSand, kFloor, kFront, kBackstop, kSides}) {
        talus_material material;
        talus_material_init(&material);
        material.density = config.sand.density;
        material.young = config.sand.young;
        material.poisson = config.sand.poisson;
        if (id != kSand) {
            material.rigid = config.walls.rigid ? 1 : 0;
            material.young = config.walls.young.value_or(config.sand.young);
            material.poisson = config.walls.poisson.value_or(config.sand.poisson);
        }
        std::int32_t got = -1;
        engine.check(talus_material_add(engine.get(), &material, &got), "adding materials");
        if (got != id) throw Failure(kExitInternal, fmt::format("material {} got the id {}", static_cast<int>(id), got));
    }
}

void add_walls(Scene& scene, const Plan& plan) {
    struct Face {
        Material material;
        int axis;
        bool is_upper;
    };
    constexpr Face faces[] = {{kFloor, 1, false}, {kFront, 0, false}, {kBackstop, 0, true}, {kSides, 2, false}, {kSides, 2, true}};
    for (Wall& wall : scene.walls) {
        const Face& face = faces[wall.id];
        talus_wall def;
        talus_wall_init(&def);
        def.material = face.material;
        for (int axis = 0; axis < 3; ++axis) {
            def.point[axis] = plan.lo[axis];
            def.normal[axis] = 0;
        }
        def.point[face.axis] = face.is_upper ? plan.hi[face.axis] : plan.lo[face.axis];
        def.normal[face.axis] = face.is_upper ? -1 : 1;
        std::int32_t got = -1;
        scene.engine.check(talus_wall_add(scene.engine.get(), &def, &got), "adding the wall " + wall.name);
        if (got != wall.id) throw Failure(kExitInternal, fmt::format("the wall {} got the id {}", wall.name, got));
    }
}

} // namespace

Scene make_scene(const Team& team, const Config& config, const Plan& plan, std::int32_t threads) {
    const talus_settings settings = settings_of(config, plan, threads);
    talus_engine* raw = nullptr;
    check_create(talus_engine_create_comm(&settings, team.comm(), &raw), config.source);
    Scene scene{Engine(raw), walls_of(config, plan)};
    add_materials(scene.engine, config);
    set_contacts(scene.engine, config, plan.has_bed_file);
    add_walls(scene, plan);
    return scene;
}

bool load_scene(const Team& team, const Config& config, const Plan& plan, std::int32_t threads, const std::string& path, Scene& out_scene,
                std::string& out_reason) {
    const talus_settings settings = settings_of(config, plan, threads);
    talus_engine* raw = nullptr;
    const std::int32_t comm = static_cast<std::int32_t>(MPI_Comm_c2f(team.comm()));
    const talus_status status = talus_checkpoint_load(path.c_str(), &settings, comm, &raw);
    if (status == TALUS_ERR_COMM || status == TALUS_ERR_ARGUMENT) check_create(status, path);
    if (status < 0) {
        out_reason = talus_message();
        return false;
    }
    out_scene = Scene{Engine(raw), walls_of(config, plan)};
    return true;
}

void fill_box(const Scene& scene, const Config& config, const Plan& plan) {
    talus_fill fill;
    talus_fill_init(&fill);
    fill.material = kSand;
    for (int axis = 0; axis < 3; ++axis) {
        fill.lo[axis] = plan.lo[axis];
        fill.hi[axis] = plan.hi[axis];
    }
    fill.radius_min = plan.radius_min;
    fill.radius_max = plan.radius_max;
    fill.count = plan.grains;
    fill.room = config.box.fill_room;
    std::int64_t placed = 0;
    scene.engine.check(talus_particles_fill(scene.engine.get(), &fill, &placed), "filling the box");
    if (placed < plan.grains)
        throw Failure(kExitInput, fmt::format("{}: box.height: only {} of {} grains found a place below {:g} m; make it higher",
                                              config.source, placed, plan.grains, plan.hi[1]));
}

void insert_bed(const Scene& scene, const Config& config, const Team& team, const Bed& bed) {
    talus_particles particles = {};
    particles.struct_size = sizeof particles;
    if (team.is_root()) {
        particles.count = static_cast<std::int64_t>(bed.label.size());
        particles.label = bed.label.data();
        particles.position = bed.position.data();
        particles.radius = bed.radius.data();
        particles.group = bed.group.empty() ? nullptr : bed.group.data();
    }
    scene.engine.check(talus_particles_insert(scene.engine.get(), &particles, config.bed.max_overlap), config.bed.file);
}

void prepare(const Scene& scene, const Config& config) {
    scene.engine.check(talus_engine_step(scene.engine.get(), 0, nullptr), config.source);
}

void switch_friction_on(const Scene& scene, const Config& config) {
    const talus_laws laws = laws_of(config);
    scene.engine.check(talus_engine_set_laws(scene.engine.get(), &laws), "switching friction on");
    set_contacts(scene.engine, config, true);
}

void set_wall_speed(const Scene& scene, double speed) {
    const double velocity[3] = {speed, 0, 0};
    for (const Wall& wall : scene.walls)
        if (wall.is_moving)
            scene.engine.check(talus_wall_set_velocity(scene.engine.get(), wall.id, velocity), "moving the wall " + wall.name);
}

} // namespace talus::sandbox
