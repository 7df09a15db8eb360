#include <cmath>
#include <numbers>

#include "apps/bench/box.hpp"
#include "apps/bench/grains.hpp"

namespace talus::bench {

namespace {

constexpr std::int64_t kGrains = 50000;
constexpr double kStep = 1.325e-5; // s, that of the peers' decks
/// As near as one number comes to the peers' decks. What LAMMPS makes of 0.2 is 0.343: its damping (Thornton et al. 2013) is that of a contact
/// which ends where it would attract, but its contacts do not end there. Model B, of another form, lies at about 0.31.
constexpr double kRestitution = 0.32;
constexpr double kSolidFraction = 0.3;
/// Largest speed along each axis at the start [m/s]. With a skin of a tenth of a diameter lists then last about five steps.
constexpr double kSpeed = 0.8;
/// Height above the grains, in those that the fastest could reach.
constexpr double kHeadroom = 2.0;

} // namespace

talus_laws gas_laws() {
    talus_laws l;
    talus_laws_init(&l);
    l.damping = TALUS_DAMPING_ATTRACTIVE;
    l.tangential = TALUS_TANGENTIAL_DISPLACEMENT;
    l.rolling = TALUS_ROLLING_NONE;
    return l;
}

Scene make_gas(const SceneOptions& o) {
    // A cube of lattice places, each with one grain at random in it.
    const auto n = static_cast<int>(std::lround(std::cbrt(static_cast<double>(o.grains > 0 ? o.grains : kGrains))));
    const double mean_cube = (kRadiusMin + kRadiusMax) * (kRadiusMin * kRadiusMin + kRadiusMax * kRadiusMax) / 4.0; // of the radii
    const double pitch = std::cbrt(4.0 / 3.0 * std::numbers::pi * mean_cube / kSolidFraction), side = n * pitch;
    Scene scene{nullptr, {0.0, 0.0, 0.0}, {side, side + kHeadroom * kSpeed * kSpeed / (2.0 * kGravity), side}};
    Grains grains;
    Random random;
    for (int x = 0; x < n; ++x)
        for (int y = 0; y < n; ++y)
            for (int z = 0; z < n; ++z) {
                const double radius = random.uniform(kRadiusMin, kRadiusMax), room = 0.5 * pitch - radius;
                std::array<double, 3> at{(x + 0.5) * pitch, (y + 0.5) * pitch, (z + 0.5) * pitch}, moving{};
                for (double& a : at) a += random.uniform(-room, room);
                for (double& v : moving) v = random.uniform(-kSpeed, kSpeed);
                grains.add(static_cast<std::int64_t>(grains.count()) + 1, at, radius, moving, kFree);
            }
    scene.engine = make_box(o, gas_laws(), kRestitution, scene.lo, scene.hi, kRadiusMax);
    insert(scene.engine.get(), grains, 0.01);
    check(talus_engine_set_time_step(scene.engine.get(), kStep), scene.engine.get());
    return scene;
}

} // namespace talus::bench
