#include <algorithm>
#include <cmath>
#include <numbers>

#include "apps/bench/grains.hpp"
#include "apps/bench/scene.hpp"

namespace talus::bench {

namespace {

constexpr std::int64_t kGrains = 50000;
constexpr double kDiameter = kRadiusMin + kRadiusMax; // m, mean
constexpr double kIncline = 24.0;                     // degrees
constexpr double kRestitution = 0.88, kFriction = 0.5;
constexpr double kStiffness = 2e5; // m g/d
constexpr double kStep = 1e-4;     // sqrt(d/g)
/// Layers of the loose lattice that the grains start from; it settles to about 25 diameters.
constexpr int kLayers = 33;
constexpr double kPitch = 2.02 * kRadiusMax; // m
constexpr double kFlowDepth = 25.0;          // diameters
/// A of Bagnold's profile v(y) = 2/3 A sqrt(g)/d (h^3/2 - (h-y)^3/2) that the grains start with; the flow finds its own soon after.
constexpr double kBagnold = 0.15;
constexpr double kScatter = 0.3; // sqrt(g d), at the start
/// The flow develops in a patch of about so many diameters, which then is laid side by side; the rest is too much to wait for.
constexpr double kPatch = 14.0;

/// A part of the set-up. Softer grains take longer steps, and find the same flow to within what a start needs; contact histories start
/// anew with each.
struct Stage {
    double stiffness, step; // of the above
    int steps;
};
constexpr Stage kDevelop[] = {{0.1, 15.0, 8000}, {1.0, 5.0, 2000}};
constexpr Stage kWarm{1.0, 1.0, 200}; // all patches together; a collision lasts about 50 steps

double grain_weight() { return kDensity * std::numbers::pi / 6.0 * kDiameter * kDiameter * kDiameter * kGravity; }
double time_unit() { return std::sqrt(kDiameter / kGravity); }

/// An incline of `side` by `side` with these grains.
Scene make_incline(const SceneOptions& o, double side, const Stage& stage, const Grains& grains) {
    Scene scene{nullptr, {0.0, -kRadiusMax, 0.0}, {side, 1.5 * kLayers * kPitch, side}};
    talus_settings s;
    talus_settings_init(&s);
    std::copy(scene.lo.begin(), scene.lo.end(), s.domain_lo);
    std::copy(scene.hi.begin(), scene.hi.end(), s.domain_hi);
    s.periodic[0] = s.periodic[2] = 1;
    const double angle = kIncline * std::numbers::pi / 180.0;
    s.gravity[0] = kGravity * std::sin(angle);
    s.gravity[1] = -kGravity * std::cos(angle);
    s.gravity[2] = 0.0;
    s.threads = o.threads;
    s.skin = o.skin;
    s.radius_max = kRadiusMax;
    s.time_step = stage.step * kStep * time_unit();
    s.laws = chute_laws();
    s.laws.stiffness_n *= stage.stiffness;
    talus_engine* raw = nullptr;
    check(talus_engine_create(&s, &raw), nullptr);
    scene.engine.reset(raw);
    talus_material m;
    talus_material_init(&m);
    m.young = kYoung;
    m.poisson = kPoisson;
    m.density = kDensity;
    check(talus_material_add(raw, &m, nullptr), raw);
    talus_contact c;
    talus_contact_init(&c);
    c.restitution = kRestitution;
    c.friction = kFriction;
    check(talus_contact_set(raw, 0, 0, &c), raw);
    check(talus_group_set(raw, kFrozen, TALUS_GROUP_FROZEN, nullptr, nullptr), raw);
    insert(raw, grains, 0.1);
    check(talus_engine_step(raw, stage.steps, nullptr), raw);
    return scene;
}

/// A layer of frozen grains, and a loose lattice of moving ones above.
Grains starting_patch(int places) {
    Grains g;
    Random random;
    const double depth = kFlowDepth * kDiameter, room = 0.5 * kPitch - kRadiusMax;
    const double speed = std::sqrt(kGravity * kDiameter);
    for (int y = 0; y <= kLayers; ++y)
        for (int x = 0; x < places; ++x)
            for (int z = 0; z < places; ++z) {
                std::array<double, 3> at{(x + 0.5) * kPitch, y * kPitch, (z + 0.5) * kPitch}, moving{};
                for (double& a : at) a += random.uniform(-room, room);
                const bool base = y == 0;
                if (base) {
                    at[1] = random.uniform(-0.4, 0.0) * kDiameter;
                } else {
                    const double height = std::min(depth, depth * y / kLayers);
                    const double profile = 2.0 / 3.0 * kBagnold * std::sqrt(kGravity) / kDiameter * (std::pow(depth, 1.5) - std::pow(depth - height, 1.5));
                    for (double& v : moving) v = random.uniform(-kScatter, kScatter) * speed;
                    moving[0] += profile;
                }
                g.add(static_cast<std::int64_t>(g.count()), at, random.uniform(kRadiusMin, kRadiusMax), moving, base ? kFrozen : kFree);
            }
    return g;
}

/// n x n of a patch, side by side.
Grains tiled(const Grains& patch, int n, double side) {
    Grains all;
    for (int x = 0; x < n; ++x)
        for (int z = 0; z < n; ++z) {
            const std::size_t from = all.count();
            const auto append = [](auto& to, const auto& items) { to.insert(to.end(), items.begin(), items.end()); };
            append(all.label, patch.label);
            append(all.position, patch.position);
            append(all.radius, patch.radius);
            append(all.velocity, patch.velocity);
            append(all.spin, patch.spin);
            append(all.group, patch.group);
            for (std::size_t k = from; k < all.count(); ++k) {
                all.label[k] += static_cast<std::int64_t>(from);
                all.position[3 * k] += x * side;
                all.position[3 * k + 2] += z * side;
            }
        }
    return all;
}

} // namespace

double chute_speed() { return std::sqrt(kGravity * kDiameter); }

talus_laws chute_laws() {
    talus_laws l;
    talus_laws_init(&l);
    l.normal = TALUS_NORMAL_LINEAR;
    l.damping = TALUS_DAMPING_ATTRACTIVE;
    l.tangential = TALUS_TANGENTIAL_FORCE;
    l.rolling = TALUS_ROLLING_NONE;
    l.tangential_damping = 0;
    l.stiffness_n = kStiffness * grain_weight() / kDiameter;
    return l;
}

Scene make_chute(const SceneOptions& o) {
    const double along = std::sqrt(static_cast<double>(o.grains > 0 ? o.grains : kGrains) / (kLayers + 1));
    const int patches = std::max(1, static_cast<int>(along * kPitch / (kPatch * kDiameter)));
    const int places = std::max(4, static_cast<int>(std::lround(along / patches)));
    const double side = places * kPitch;
    Grains patch = starting_patch(places);
    for (const Stage& stage : kDevelop) patch = gather(make_incline(o, side, stage, patch).engine.get());
    return make_incline(o, patches * side, kWarm, tiled(patch, patches, side));
}

} // namespace talus::bench
