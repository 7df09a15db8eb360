#include "apps/bench/box.hpp"

#include <algorithm>

namespace talus::bench {

void check(talus_status status, const talus_engine* engine) {
    if (status < 0) core::fail(static_cast<core::ErrorKind>(status), "{}", engine != nullptr ? talus_engine_message(engine) : talus_message());
}

EnginePtr make_box(const SceneOptions& o, const talus_laws& laws, double restitution, const std::array<double, 3>& lo, const std::array<double, 3>& hi, double radius_max) {
    const double margin = 4.0 * radius_max;
    talus_settings s;
    talus_settings_init(&s);
    for (std::size_t a = 0; a < 3; ++a) {
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
    c.restitution = restitution;
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
    return engine;
}

} // namespace talus::bench
