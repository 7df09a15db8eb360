#include "apps/bench/scene.hpp"

#include <algorithm>
#include <cmath>

#include "apps/sandbox/bed_file.hpp"

namespace talus::bench {

namespace {

constexpr double kYoung = 1e7, kPoisson = 0.2, kDensity = 2600.0;
constexpr double kStepFraction = 0.15;
constexpr int kSettleSteps = 3000, kWarmSteps = 300;

sandbox::Bed read(const SceneOptions& o) {
    sandbox::Faults faults;
    sandbox::Bed bed = sandbox::read_bed(o.bed, o.axes, faults);
    faults.throw_if_any(o.bed);
    return bed;
}

} // namespace

void check(talus_status status, const talus_engine* engine) {
    if (status < 0) core::fail(static_cast<core::ErrorKind>(status), "{}", engine != nullptr ? talus_engine_message(engine) : talus_message());
}

EnginePtr make_bed(const SceneOptions& o, const talus_laws& laws) {
    sandbox::Bed bed;
    double radius_min = 1.02375e-3, radius_max = 1.25125e-3; // the beds of the comparison with peers
    double lo[3] = {0.0, 0.0, 0.0}, hi[3];
    if (!o.bed.empty()) {
        bed = read(o);
        for (std::size_t a = 0; a < 3; ++a) {
            lo[a] = bed.lo[a];
            hi[a] = bed.hi[a];
        }
        const auto [least, most] = std::minmax_element(bed.radius.begin(), bed.radius.end());
        radius_min = *least;
        radius_max = *most;
    } else {
        const double side = 2.0 * radius_max * std::cbrt(static_cast<double>(o.grains));
        hi[0] = side;
        hi[1] = 3.0 * side;
        hi[2] = side;
    }
    const double margin = 4.0 * radius_max;

    talus_settings s;
    talus_settings_init(&s);
    for (int a = 0; a < 3; ++a) {
        s.domain_lo[a] = lo[a] - (a == 2 ? 0.0 : margin);
        s.domain_hi[a] = hi[a] + (a == 2 ? 0.0 : margin);
    }
    s.periodic[2] = 1;
    s.threads = o.threads;
    s.skin = o.skin;
    s.time_step = 1.0;
    s.laws = laws;
    talus_engine* raw = nullptr;
    check(talus_engine_create(&s, &raw), nullptr);
    EnginePtr engine(raw);

    talus_material m;
    talus_material_init(&m);
    m.young = kYoung;
    m.poisson = kPoisson;
    m.density = kDensity;
    std::int32_t sand = 0, wall = 0;
    check(talus_material_add(raw, &m, &sand), raw);
    check(talus_material_add(raw, &m, &wall), raw);
    talus_contact c;
    talus_contact_init(&c);
    c.restitution = 0.2;
    c.friction = 0.6;
    c.rolling_friction = 0.05;
    check(talus_contact_set(raw, sand, sand, &c), raw);
    c.friction = 0.25;
    check(talus_contact_set(raw, sand, wall, &c), raw);
    const double planes[3][6] = {{0.0, lo[1], 0.0, 0.0, 1.0, 0.0}, {lo[0], 0.0, 0.0, 1.0, 0.0, 0.0}, {hi[0], 0.0, 0.0, -1.0, 0.0, 0.0}};
    for (const auto& p : planes) {
        talus_wall w;
        talus_wall_init(&w);
        w.material = wall;
        std::copy(p, p + 3, w.point);
        std::copy(p + 3, p + 6, w.normal);
        check(talus_wall_add(raw, &w, nullptr), raw);
    }

    if (!o.bed.empty()) {
        talus_particles p{};
        p.struct_size = sizeof p;
        p.count = static_cast<std::int64_t>(bed.label.size());
        p.label = bed.label.data();
        p.position = bed.position.data();
        p.radius = bed.radius.data();
        check(talus_particles_insert(raw, &p, 0.1), raw);
    } else {
        talus_fill f;
        talus_fill_init(&f);
        f.material = sand;
        f.radius_min = radius_min;
        f.radius_max = radius_max;
        f.count = o.grains;
        std::copy(lo, lo + 3, f.lo);
        std::copy(hi, hi + 3, f.hi);
        check(talus_particles_fill(raw, &f, nullptr), raw);
    }
    double critical = 0.0;
    check(talus_engine_critical_step(raw, &critical), raw);
    check(talus_engine_set_time_step(raw, kStepFraction * critical), raw);
    if (o.bed.empty()) check(talus_engine_step(raw, kSettleSteps, nullptr), raw);
    const double in[3] = {0.1, 0.0, 0.0};
    check(talus_wall_set_velocity(raw, 1, in), raw);
    check(talus_engine_step(raw, kWarmSteps, nullptr), raw);
    return engine;
}

} // namespace talus::bench
