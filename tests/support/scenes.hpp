// scenes.hpp: scenes on the C ABI for tests of what must not show in the bits: ranks, threads, skin, tiles, cuts. Initial states
// follow from labels alone. Each scene has contacts from its first steps and rebuilds its lists many times in some hundred steps.
#pragma once

#include <talus.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "bed.hpp"

namespace talus::test {

/// How a scene is run. Nothing of it may show in the bits.
struct HowToRun {
    int32_t comm = TALUS_SERIAL; // or a Fortran handle
    int32_t threads = 1;
    double skin = 0.1; // of the mean diameter; 0: automatic
    int32_t rebalance = TALUS_REBALANCE_OFF;
    int32_t rebalance_interval = 1;
    int32_t tile_grains = 128;
    int32_t rank_grid[3] = {0, 0, 0};
};

/// Owner of an engine, serial or over ranks. Errors are thrown, the same on every rank.
class World {
public:
    World(const talus_settings& settings, int32_t comm) {
        talus_engine* engine = nullptr;
        const talus_status status = comm == TALUS_SERIAL ? talus_engine_create(&settings, &engine) : talus_engine_create_mpi(&settings, comm, &engine);
        if (status != TALUS_OK) throw TalusError(status, talus_message());
        engine_.reset(engine);
        check(talus_engine_rank(engine, &rank_, &ranks_));
    }
    explicit World(talus_engine* engine) : engine_(engine) { check(talus_engine_rank(engine, &rank_, &ranks_)); }

    talus_engine* handle() { return engine_.get(); }
    int32_t rank() const { return rank_; }
    int32_t ranks() const { return ranks_; }
    void check(talus_status status) {
        if (status != TALUS_OK) throw TalusError(status, talus_engine_message(engine_.get()));
    }
    void step(int64_t n) { check(talus_engine_step(engine_.get(), n, nullptr)); }
    talus_state state() {
        talus_state s;
        talus_state_init(&s);
        check(talus_engine_state(engine_.get(), &s));
        return s;
    }
    int32_t material(const Solid& solid) {
        talus_material m;
        talus_material_init(&m);
        m.young = solid.young;
        m.poisson = solid.poisson;
        m.density = solid.density;
        int32_t id = -1;
        check(talus_material_add(engine_.get(), &m, &id));
        return id;
    }
    void contact(int32_t a, int32_t b, double restitution, double friction, double rolling_friction) {
        talus_contact c;
        talus_contact_init(&c);
        c.restitution = restitution;
        c.friction = friction;
        c.rolling_friction = rolling_friction;
        check(talus_contact_set(engine_.get(), a, b, &c));
    }
    int32_t wall(int32_t material, const Vec3& point, const Vec3& normal, const Vec3& velocity = {}) {
        talus_wall w;
        talus_wall_init(&w);
        w.material = material;
        for (std::size_t a = 0; a < 3; ++a) {
            w.point[a] = point[a];
            w.normal[a] = normal[a];
            w.velocity[a] = velocity[a];
        }
        int32_t id = -1;
        check(talus_wall_add(engine_.get(), &w, &id));
        return id;
    }
    /// Every rank holds the whole list and gives its share of it; labels are first_label + place in the list.
    void insert(const std::vector<Grain>& grains, double max_overlap, int64_t first_label = 0) {
        std::vector<int64_t> label;
        std::vector<double> position, radius, velocity, spin;
        std::vector<int32_t> material, group;
        for (std::size_t k = 0; k < grains.size(); ++k) {
            if (static_cast<int32_t>(k % static_cast<std::size_t>(ranks_)) != rank_) continue;
            label.push_back(first_label + static_cast<int64_t>(k));
            radius.push_back(grains[k].radius);
            material.push_back(grains[k].material);
            group.push_back(grains[k].group);
            for (std::size_t a = 0; a < 3; ++a) {
                position.push_back(grains[k].position[a]);
                velocity.push_back(grains[k].velocity[a]);
                spin.push_back(grains[k].spin[a]);
            }
        }
        talus_particles p{};
        p.struct_size = sizeof p;
        p.count = static_cast<int64_t>(label.size());
        p.label = label.data();
        p.position = position.data();
        p.radius = radius.data();
        p.velocity = velocity.data();
        p.angular_velocity = spin.data();
        p.material = material.data();
        p.group = group.data();
        check(talus_particles_insert(engine_.get(), &p, max_overlap));
    }
    int64_t fill(const Vec3& lo, const Vec3& hi, double radius_min, double radius_max, int64_t count, int64_t first_label, double room) {
        talus_fill f;
        talus_fill_init(&f);
        for (std::size_t a = 0; a < 3; ++a) {
            f.lo[a] = lo[a];
            f.hi[a] = hi[a];
        }
        f.radius_min = radius_min;
        f.radius_max = radius_max;
        f.count = count;
        f.first_label = first_label;
        f.room = room;
        int64_t n = 0;
        check(talus_particles_fill(engine_.get(), &f, &n));
        return n;
    }

private:
    struct Destroy {
        void operator()(talus_engine* e) const { talus_engine_destroy(e); }
    };
    std::unique_ptr<talus_engine, Destroy> engine_;
    int32_t rank_ = 0, ranks_ = 1;
};

inline constexpr Solid kSceneSand{1.0e7, 0.2, 2600.0};
inline constexpr double kSceneRadius = 1.0e-3; // mean
inline constexpr double kSceneStep = 1.0e-5;   // 0.12 of the Rayleigh step

inline talus_settings scene_settings(const Vec3& lo, const Vec3& hi, const HowToRun& run) {
    talus_settings s;
    talus_settings_init(&s);
    for (std::size_t a = 0; a < 3; ++a) {
        s.domain_lo[a] = lo[a];
        s.domain_hi[a] = hi[a];
        s.rank_grid[a] = run.rank_grid[a];
    }
    s.time_step = kSceneStep;
    s.threads = run.threads;
    s.skin = run.skin * 2.0 * kSceneRadius;
    s.rebalance = run.rebalance;
    s.rebalance_interval = run.rebalance_interval;
    s.tile_grains = run.tile_grains;
    s.seed = 7;
    return s;
}

/// nx * ny * nz grains on a cubic lattice one mean diameter apart, from `origin`; radii differ by up to `spread`, so that about half of the
/// neighbours touch, and velocities by up to `speed`.
inline std::vector<Grain> lattice(int nx, int ny, int nz, const Vec3& origin, double spread, double speed) {
    std::vector<Grain> grains;
    Random random(11);
    for (int x = 0; x < nx; ++x)
        for (int y = 0; y < ny; ++y)
            for (int z = 0; z < nz; ++z) {
                Grain g;
                const double pitch = 2.0 * kSceneRadius;
                g.position = origin + Vec3{pitch * (x + 0.5), pitch * (y + 0.5), pitch * (z + 0.5)};
                g.radius = kSceneRadius * random.uniform(1.0 - spread, 1.0 + spread);
                g.velocity = random.vector(speed);
                g.spin = random.vector(speed / kSceneRadius);
                grains.push_back(g);
            }
    return grains;
}

struct Scene {
    const char* name;
    World (*make)(const HowToRun&);
    void (*advance)(World&, int64_t from, int64_t to, int64_t total); // steps from..to of a run of `total`
    bool slides;                                                      // sliding contacts belong to it
};

inline void plain_advance(World& world, int64_t from, int64_t to, int64_t) { world.step(to - from); }

/// A box of 2,400 grains between a front and a back wall, periodic in z, over a floor that is drawn away in +x: everything slides.
/// Hertz, clipped damping, force history with rescaling, constant rolling torque: the default law.
inline World make_shear(const HowToRun& run) {
    const double d = 2.0 * kSceneRadius;
    const Vec3 size{24 * d, 10 * d, 10 * d};
    talus_settings s = scene_settings({-d, -d, 0.0}, {size[0] + d, 3.0 * size[1] + d, size[2]}, run);
    s.periodic[2] = 1;
    s.gravity[1] = -50.0;
    World world(s, run.comm);
    const int32_t sand = world.material(kSceneSand), plate = world.material({5.0e7, 0.3, 2600.0});
    world.contact(sand, sand, 0.2, 0.6, 0.05);
    world.contact(sand, plate, 0.3, 0.4, 0.02);
    world.wall(plate, {0, 0, 0}, {0, 1, 0}, {1.0, 0, 0});
    world.wall(plate, {0, 3.0 * size[1], 0}, {0, -1, 0});
    world.wall(plate, {0, 0, 0}, {1, 0, 0});
    world.wall(plate, {size[0], 0, 0}, {-1, 0, 0});
    world.insert(lattice(24, 10, 10, {0, 0, 0}, 0.02, 0.05), 0.1);
    return world;
}

/// Grains thrown into a closed box, half of them after half of the run. Displacement history, attractive damping, constant rolling
/// torque with own radii.
inline World make_pour(const HowToRun& run) {
    const double d = 2.0 * kSceneRadius;
    const Vec3 size{16 * d, 40 * d, 12 * d};
    talus_settings s = scene_settings({-d, -d, -d}, {size[0] + d, size[1] + d, size[2] + d}, run);
    s.laws.tangential = TALUS_TANGENTIAL_DISPLACEMENT;
    s.laws.damping = TALUS_DAMPING_ATTRACTIVE;
    s.laws.rolling_radius = TALUS_ROLLING_RADIUS_OWN;
    s.radius_max = 1.1 * kSceneRadius;
    World world(s, run.comm);
    const int32_t sand = world.material(kSceneSand);
    world.contact(sand, sand, 0.5, 0.5, 0.1);
    for (std::size_t a = 0; a < 3; ++a) {
        Vec3 n{};
        n[a] = 1.0;
        world.wall(sand, {0, 0, 0}, n);
        n[a] = -1.0;
        world.wall(sand, size, n);
    }
    world.fill({0, 0, 0}, {size[0], 0.5 * size[1], size[2]}, 0.9 * kSceneRadius, 1.1 * kSceneRadius, 1000, 0, 0.15);
    const double down[3] = {0.3, -2.0, 0.1};
    world.check(talus_particles_add_velocity(world.handle(), down));
    return world;
}
inline void advance_pour(World& world, int64_t from, int64_t to, int64_t total) {
    const int64_t half = total / 2;
    if (from < half) world.step(std::min(to, half) - from);
    if (from <= half && half < to) {
        const double d = 2.0 * kSceneRadius;
        world.fill({0, 26 * d, 0}, {16 * d, 40 * d, 12 * d}, 0.9 * kSceneRadius, 1.1 * kSceneRadius, 1000, 5000, 0.1);
        const double down[3] = {0.0, -0.5, 0.0};
        world.check(talus_particles_add_velocity(world.handle(), down));
    }
    if (to > half) world.step(to - std::max(from, half));
}

/// A layer on a floor, periodic in x and z, sliding down under a tilted gravity. Linear law, force history without rescaling, rolling
/// spring, energy ledger.
inline World make_periodic(const HowToRun& run) {
    const double d = 2.0 * kSceneRadius;
    const Vec3 size{20 * d, 8 * d, 14 * d};
    talus_settings s = scene_settings({0.0, -d, 0.0}, {size[0], 3.0 * size[1] + d, size[2]}, run);
    s.periodic[0] = s.periodic[2] = 1;
    const double pull[3] = {40.0, -60.0, 15.0};
    for (int a = 0; a < 3; ++a) s.gravity[a] = pull[a];
    s.laws.normal = TALUS_NORMAL_LINEAR;
    s.laws.stiffness_n = 2.0e3;
    s.laws.tangential = TALUS_TANGENTIAL_FORCE;
    s.laws.rolling = TALUS_ROLLING_SPRING;
    s.energy_ledger = 1;
    World world(s, run.comm);
    const int32_t sand = world.material(kSceneSand);
    world.contact(sand, sand, 0.4, 0.3, 0.1);
    world.wall(sand, {0, 0, 0}, {0, 1, 0}, {-0.5, 0, 0.2});
    world.wall(sand, {0, 3.0 * size[1], 0}, {0, -1, 0});
    world.insert(lattice(20, 8, 14, {0, 0, 0}, 0.02, 0.2), 0.1);
    return world;
}

/// Elastic, frictionless grains on a lattice of n[0] x n[1] x n[2] in a box that is periodic on all axes, from faces, edges and corners on.
inline World make_elastic_gas(const Vec3& size, const std::array<int, 3>& n, double speed, double spin, std::uint64_t seed, const HowToRun& run) {
    talus_settings s = scene_settings({0, 0, 0}, size, run);
    for (int a = 0; a < 3; ++a) {
        s.periodic[a] = 1;
        s.gravity[a] = 0.0;
    }
    s.laws.tangential = TALUS_TANGENTIAL_NONE;
    s.laws.rolling = TALUS_ROLLING_NONE;
    World world(s, run.comm);
    const int32_t glass = world.material(kSceneSand);
    world.contact(glass, glass, 1.0, 0.0, 0.0);
    std::vector<Grain> grains;
    Random random(seed);
    for (int x = 0; x < n[0]; ++x)
        for (int y = 0; y < n[1]; ++y)
            for (int z = 0; z < n[2]; ++z) grains.push_back({{size[0] / n[0] * x, size[1] / n[1] * y, size[2] / n[2] * z}, kSceneRadius, random.vector(speed), random.vector(spin)});
    world.insert(grains, 0.0);
    return world;
}
inline World make_gas(const HowToRun& run) {
    const double side = 12.0 * 2.0 * kSceneRadius;
    return make_elastic_gas({side, side, side}, {8, 8, 8}, 2.0, 100.0, 23, run);
}

inline constexpr Scene kShear{"shear", make_shear, plain_advance, true};
inline constexpr Scene kPour{"pour", make_pour, advance_pour, true};
inline constexpr Scene kPeriodic{"periodic", make_periodic, plain_advance, true};
inline constexpr Scene kGas{"gas", make_gas, plain_advance, false};

} // namespace talus::test
