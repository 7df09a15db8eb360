// shear.cpp: a bed of grains is sheared between two walls at a given pressure, and tells its friction. In C++ the engine has an
// owner that frees it, and a status that is a failure becomes an exception; Talus itself throws nothing at its host.
//
//   c++ -std=c++17 shear.cpp $(pkg-config --cflags --libs talus) -o shear && ./shear [GRAINS [THREADS]]
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <string>
#include <talus.h>

namespace {
constexpr double kRadius = 0.002, kSide = 0.03, kPressure = 1000, kSpeed = 0.3; // [m], [m], [Pa], [m/s]

struct Destroy {
    void operator()(talus_engine* engine) const { talus_engine_destroy(engine); }
};
using Engine = std::unique_ptr<talus_engine, Destroy>;
// The text belongs to the engine, or to the thread where none was made, until the next call: the exception keeps a copy.
void check(const Engine& engine, talus_status status, const char* doing) {
    if (status >= 0) return;
    const char* text = engine ? talus_engine_message(engine.get()) : talus_message();
    throw std::runtime_error(std::string(doing) + ": " + talus_status_string(status) + ": " + text);
}

Engine make_engine(double height, int threads) {
    talus_settings settings;
    check(nullptr, talus_settings_init(&settings), "preparing settings");
    for (int a = 0; a < 3; ++a) {
        settings.domain_lo[a] = settings.gravity[a] = 0; // what presses is the lid alone
        settings.domain_hi[a] = a == 1 ? height : kSide;
        settings.periodic[a] = a != 1;
    }
    settings.threads = threads, settings.time_step = 3e-5;
    talus_engine* engine = nullptr;
    check(nullptr, talus_engine_create(&settings, &engine), "creating the engine");
    return Engine(engine);
}

void build(const Engine& engine, double height, std::int64_t grains) {
    talus_material sand;
    talus_contact contact;
    check(engine, talus_material_init(&sand), "preparing");
    check(engine, talus_contact_init(&contact), "preparing");
    sand.young = 1e7, sand.poisson = 0.25, sand.density = 2600;
    contact.restitution = 0.5;
    std::int32_t id = 0;
    for (const bool is_wall : {false, true}) { // material 0: grains; 1: walls, rougher, so that it is the bed that shears
        contact.friction = is_wall ? 2 : 0.5, contact.rolling_friction = is_wall ? 0.5 : 0.05;
        check(engine, talus_material_add(engine.get(), &sand, &id), "adding a material");
        check(engine, talus_contact_set(engine.get(), 0, id, &contact), "setting a contact");
    }
    for (const bool is_lid : {false, true}) { // wall 0: the floor; 1: the lid
        talus_wall plane;
        check(engine, talus_wall_init(&plane), "preparing");
        plane.material = 1;
        plane.point[1] = is_lid ? height : 0, plane.normal[1] = is_lid ? -1 : 1;
        check(engine, talus_wall_add(engine.get(), &plane, &id), "adding a wall");
    }
    talus_fill fill;
    check(engine, talus_fill_init(&fill), "preparing");
    for (int a = 0; a < 3; ++a) fill.lo[a] = 0, fill.hi[a] = a == 1 ? height : kSide;
    fill.radius_min = 0.7 * kRadius, fill.radius_max = kRadius, fill.count = grains;
    check(engine, talus_particles_fill(engine.get(), &fill, &grains), "filling"); // all find a place in run()'s height
}

void run(std::int64_t grains, int threads) {
    const double height = (static_cast<double>(grains) / 36 + 2) * 2.2 * kRadius; // 36 in a layer of the lattice they start on
    const Engine engine = make_engine(height, threads);
    build(engine, height, grains);
    double along = 0, across = 0, stress[9], solid = 0, touching = 0;
    talus_wall_state walls[2];
    for (talus_wall_state& wall : walls) check(engine, talus_wall_state_init(&wall), "preparing");
    const talus_wall_state &floor = walls[0], &lid = walls[1];
    for (int k = 0, sheared = 0; sheared < 2000; ++k) {
        for (int id : {0, 1}) check(engine, talus_wall_get(engine.get(), id, &walls[id]), "reading a wall");
        const double pressure = lid.force[1] / (kSide * kSide);
        if (k > 20000) throw std::runtime_error("the lid never met the bed");
        if (sheared > 0 || pressure > kPressure) ++sheared; // first it has to come down
        if (sheared > 1000) along += floor.force[0], across -= floor.force[1];
        // The lid keeps its pressure: it gives way to more and follows less.
        const double velocity[3] = {sheared > 0 ? kSpeed : 0, 2e-4 * (pressure - kPressure), 0};
        check(engine, talus_wall_set_velocity(engine.get(), 1, velocity), "moving the lid");
        check(engine, talus_engine_step(engine.get(), 10, nullptr), "shearing");
    }
    const double lo[3] = {0, 0.2 * lid.point[1], 0}, hi[3] = {kSide, 0.8 * lid.point[1], kSide};
    check(engine, talus_engine_stress(engine.get(), lo, hi, stress, &solid, &touching), "asking for the stress");
    std::printf("bed %.1f mm high, solid fraction %.3f, %.2f contacts a grain\n", 1e3 * lid.point[1], solid, touching);
    std::printf("stress ratio %.3f (mean, floor), %.3f (last, inside)\n", along / across, std::abs(stress[1] / stress[4]));
}
} // namespace

int main(int argc, char** argv) try {
    run(argc > 1 ? std::atoll(argv[1]) : 600, argc > 2 ? std::atoi(argv[2]) : 1);
} catch (const std::exception& error) {
    std::fprintf(stderr, "shear: %s\n", error.what());
    return 1;
}
