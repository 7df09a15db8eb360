#include <algorithm>
#include <cmath>

#include "apps/bench/box.hpp"

namespace talus::bench {

namespace {

constexpr std::int64_t kGrains = 20000;
constexpr double kRestitution = 0.2;
constexpr double kStepFraction = 0.15; // of the Rayleigh step
constexpr int kSettleSteps = 3000, kWarmSteps = 300;

void set_step(talus_engine* engine) {
    double critical = 0.0;
    check(talus_engine_critical_step(engine, &critical), engine);
    check(talus_engine_set_time_step(engine, kStepFraction * critical), engine);
}

Scene of_file(const SceneOptions& o, const talus_laws& laws) {
    const sandbox::Bed bed = read_bed(o);
    Scene scene{make_box(o, laws, kRestitution, bed.lo, bed.hi, *std::max_element(bed.radius.begin(), bed.radius.end())), bed.lo, bed.hi};
    talus_engine* engine = scene.engine.get();
    talus_particles p{};
    p.struct_size = sizeof p;
    p.count = static_cast<std::int64_t>(bed.label.size());
    p.label = bed.label.data();
    p.position = bed.position.data();
    p.radius = bed.radius.data();
    check(talus_particles_insert(engine, &p, 0.1), engine);
    set_step(engine);
    return scene;
}

Scene settled(const SceneOptions& o, const talus_laws& laws) {
    const std::int64_t grains = o.grains > 0 ? o.grains : kGrains;
    const double side = 2.0 * kRadiusMax * std::cbrt(static_cast<double>(grains));
    Scene scene{nullptr, {0.0, 0.0, 0.0}, {side, 3.0 * side, side}};
    scene.engine = make_box(o, laws, kRestitution, scene.lo, scene.hi, kRadiusMax);
    talus_engine* engine = scene.engine.get();
    talus_fill f;
    talus_fill_init(&f);
    f.radius_min = kRadiusMin;
    f.radius_max = kRadiusMax;
    f.count = grains;
    std::copy(scene.lo.begin(), scene.lo.end(), f.lo);
    std::copy(scene.hi.begin(), scene.hi.end(), f.hi);
    check(talus_particles_fill(engine, &f, nullptr), engine);
    set_step(engine);
    check(talus_engine_step(engine, kSettleSteps, nullptr), engine);
    return scene;
}

} // namespace

sandbox::Bed read_bed(const SceneOptions& o) {
    sandbox::Faults faults;
    sandbox::Bed bed = sandbox::read_bed(o.bed, o.axes, faults);
    faults.throw_if_any(o.bed);
    return bed;
}

Scene make_bed(const SceneOptions& o, const talus_laws& laws) {
    Scene scene = o.bed.empty() ? settled(o, laws) : of_file(o, laws);
    const double in[3] = {0.1, 0.0, 0.0};
    check(talus_wall_set_velocity(scene.engine.get(), 1, in), scene.engine.get());
    check(talus_engine_step(scene.engine.get(), kWarmSteps, nullptr), scene.engine.get());
    return scene;
}

} // namespace talus::bench
