// Oblique impact: Chung and Ooi (2011) tests 4 to 8 and the sweep for gain of energy. physics.md sections 3 and 6.
//
// A sphere that slides through the whole contact gets the tangential impulse mu times the normal one, exactly, whatever
// the step; so the sliding branch is compared at the accuracy of the normal restitution alone. Below it the figures come
// from integrating the law; those here were recomputed for this file by an independent midpoint integration (20000 steps
// a contact, numpy), which agrees with physics.md in every figure but two (see kStickingAngles).

#include "../support/bounce.hpp"
#include "../support/engine.hpp"
#include "../support/theory.hpp"

#include <gtest/gtest.h>

#include <string>

namespace talus::test {
namespace {

double radians(double degrees) { return degrees * kPi / 180.0; }

// ---- Test 4: aluminium oxide on a rigid wall -------------------------------------------------------------------------

constexpr Solid kAluminiumOxide{380e9, 0.23, 4000.0};
constexpr double kOxideRadius = 2.5e-3;
constexpr double kOxideSpeed = 3.9;
constexpr double kOxideRestitution = 0.98;
constexpr double kOxideFriction = 0.092;

std::vector<Landing> shoot_oxide(const std::vector<double>& degrees, int32_t tangential, double steps) {
    BounceScene scene;
    scene.solid = kAluminiumOxide;
    scene.radius = kOxideRadius;
    scene.laws.tangential = tangential;
    scene.laws.tangential_damping = 0;
    scene.kinds = {{kOxideRestitution, kOxideFriction}};
    for (const double degree : degrees) {
        const double angle = radians(degree);
        scene.launches.push_back({{kOxideSpeed * std::sin(angle), -kOxideSpeed * std::cos(angle), 0.0}, {}, 0, 1.37});
    }
    scene.time_step = HertzPair::on_rigid_wall(kAluminiumOxide, kOxideRadius).duration(kOxideSpeed) / steps;
    return bounce(scene);
}

TEST(AluminiumOxide, slides_through_the_contact_from_thirty_degrees_on) {
    const std::vector<double> degrees{30.0, 40.0, 50.0, 60.0, 70.0, 85.0};
    for (const int32_t tangential : {TALUS_TANGENTIAL_FORCE_RESCALED, TALUS_TANGENTIAL_FORCE, TALUS_TANGENTIAL_DISPLACEMENT}) {
        const auto landings = shoot_oxide(degrees, tangential, 4000.0);
        for (std::size_t i = 0; i < degrees.size(); ++i) {
            const double angle = radians(degrees[i]);
            const double impulse = kOxideFriction * (1.0 + kOxideRestitution);
            const double rebound = landings[i].velocity[0] / (kOxideSpeed * std::sin(angle));
            const double spin = -2.5 * impulse * kOxideSpeed * std::cos(angle) / kOxideRadius;
            // 1e-5: the restitution's own error at 4000 steps is 1e-6; at 30 degrees, tan/mu = 6.28 is so close to the edge
            // of sliding (7 - E*/(6 G*) = 6.23 at e = 1) that the contact sticks for its last moment: 3e-6.
            EXPECT_NEAR(rebound, 1.0 - impulse / std::tan(angle), 1e-5) << degrees[i] << " degrees, law " << tangential;
            EXPECT_NEAR(landings[i].spin[2] / spin, 1.0, 1e-5) << degrees[i] << " degrees, law " << tangential;
        }
        EXPECT_NEAR(landings[0].velocity[0] / (kOxideSpeed * 0.5), 0.6845, 6e-5);
        EXPECT_NEAR(-landings[0].spin[2], 615.2, 0.06);
        EXPECT_NEAR(-landings[2].spin[2], 456.6, 0.06);
    }
}

struct StickingFigures {
    const char* name;
    int32_t tangential;
    double rebound[5];
};

constexpr double kStickingAngles[] = {5.0, 10.0, 15.0, 20.0, 25.0};
constexpr StickingFigures kStickingFigures[] = {
    // physics.md has 0.952 and 0.697 for the first two: 1e-3 low against both integrations of this law.
    {"displacement_history", TALUS_TANGENTIAL_DISPLACEMENT, {0.9528, 0.6980, 0.6299, 0.6201, 0.6381}},
    {"force_history_rescaled", TALUS_TANGENTIAL_FORCE_RESCALED, {0.8612, 0.7106, 0.6314, 0.6201, 0.6381}},
    {"force_history", TALUS_TANGENTIAL_FORCE, {0.8904, 0.7134, 0.6275, 0.6097, 0.6279}},
};

class AluminiumOxideSticking : public testing::TestWithParam<StickingFigures> {};

TEST_P(AluminiumOxideSticking, rebounds_below_thirty_degrees_as_its_law_does) {
    const std::vector<double> degrees(std::begin(kStickingAngles), std::end(kStickingAngles));
    const auto landings = shoot_oxide(degrees, GetParam().tangential, 4000.0);
    for (std::size_t i = 0; i < degrees.size(); ++i)
        // Half a unit of the last digit and the first-order error of the step, 1e-4 at 5 degrees.
        EXPECT_NEAR(landings[i].velocity[0] / (kOxideSpeed * std::sin(radians(degrees[i]))), GetParam().rebound[i], 2e-4)
            << degrees[i] << " degrees";
}

INSTANTIATE_TEST_SUITE_P(Laws, AluminiumOxideSticking, testing::ValuesIn(kStickingFigures),
                         [](const auto& info) { return std::string(info.param.name); });

// ---- Tests 5, 6 and 8: the sliding branch ----------------------------------------------------------------------------

constexpr Solid kAlloy{70e9, 0.33, 2700.0};
constexpr double kAlloyRadius = 1e-3;

/// Smallest slip over friction, psi1 = vst/(mu vn), at e = 1 for which the sphere slides to the very end. At the end the slip
/// has turned round; it still slides while the spring, unloading at k_t |vt|, is slower than the cap mu dFn/dt. With
/// k_t = 8 G* a, dFn/dt = 2 E* a vn and |vt| = (7 - psi1) mu vn. A history that already unloads with the contact radius (or
/// stores a displacement) has a third less to go.
double sliding_edge(const Solid& solid, int32_t tangential) {
    const HertzPair pair = HertzPair::on_rigid_wall(solid, 1.0);
    const double share = tangential == TALUS_TANGENTIAL_FORCE ? 1.0 : 2.0 / 3.0;
    return 7.0 - share * pair.modulus / (4.0 * pair.shear);
}

TEST(SlidingImpact, loses_seven_times_the_friction_whether_by_velocity_or_by_spin) {
    const double vn = 0.2;
    const double friction = 0.3;
    for (const int32_t tangential : {TALUS_TANGENTIAL_FORCE_RESCALED, TALUS_TANGENTIAL_FORCE, TALUS_TANGENTIAL_DISPLACEMENT}) {
        const double edge = sliding_edge(kAlloy, tangential);
        EXPECT_LE(edge, 6.35); // physics.md: from 6 on, true for force history; the other two need 7 - E*/(6 G*)
        BounceScene scene;
        scene.solid = kAlloy;
        scene.radius = kAlloyRadius;
        scene.laws.tangential = tangential;
        scene.kinds = {{1.0, friction}};
        const std::vector<double> slips{std::max(6.0, edge + 0.02), 6.5, 7.0, 10.0, 30.0};
        for (const double psi : slips) { // test 5: tangential velocity; test 6: spin
            const double slip = psi * friction * vn;
            scene.launches.push_back({{slip, -vn, 0.0}, {}, 0, 1.37});
            scene.launches.push_back({{0.0, -vn, 0.0}, {0.0, 0.0, slip / kAlloyRadius}, 0, 1.37});
        }
        scene.time_step = HertzPair::on_rigid_wall(kAlloy, kAlloyRadius).duration(vn) / 4000.0;
        const auto landings = bounce(scene);
        for (std::size_t i = 0; i < landings.size(); ++i) {
            const double psi = slips[i / 2];
            const Launch& launch = scene.launches[i];
            const double slip = (landings[i].velocity[0] + kAlloyRadius * landings[i].spin[2]) / (friction * vn);
            const double spin = kAlloyRadius * (landings[i].spin[2] - launch.spin[2]) / (friction * vn);
            // Exact up to the normal restitution at e = 1 (1e-9) and the rounding of forces.
            EXPECT_NEAR(slip, psi - 7.0, 1e-7) << "psi1 = " << psi << ", law " << tangential;
            EXPECT_NEAR(spin, -5.0, 1e-7) << "psi1 = " << psi << ", law " << tangential;
        }
    }
}

/// Two spheres that meet along (2, 3, 6)/7 and part again; the frame moves so that both have velocities.
struct Encounter {
    Vec3 normal{2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0}; // from the first to the second
    double radius_a, radius_b;
    double speed; // of closing
    Vec3 slip;    // of the first over the second, across the normal
    Vec3 spin_a, spin_b;
    double restitution, friction;
};

struct Parting {
    Vec3 velocity_a, velocity_b, spin_a, spin_b;
    double mean_force; // N, normal, over the elastic duration
    double unit;       // N, of force sums
};

Parting meet(const Encounter& m, int32_t tangential) {
    const double reach = 40.0 * (m.radius_a + m.radius_b);
    const double mass_a = kAlloy.mass(m.radius_a);
    const double mass_b = kAlloy.mass(m.radius_b);
    HertzPair pair = HertzPair::equal_spheres(kAlloy, 1.0); // E* and G*; radius and mass are put in
    pair.radius = m.radius_a * m.radius_b / (m.radius_a + m.radius_b);
    pair.mass = mass_a * mass_b / (mass_a + mass_b);
    const double duration = pair.duration(m.speed);
    const double time_step = duration / 4000.0;
    talus_settings settings = bare_settings({-reach, -reach, -reach}, {reach, reach, reach}, time_step);
    settings.laws.tangential = tangential;
    Engine engine(settings);
    const int32_t alloy = engine.material(kAlloy.young, kAlloy.poisson, kAlloy.density);
    engine.contact(alloy, alloy, m.restitution, m.friction);
    const Vec3 drift{0.01, -0.02, 0.03};
    const Vec3 relative = m.speed * m.normal + m.slip;
    const double gap = 1.37 * time_step * m.speed;
    // The pair must touch along `normal`: step back from the touch by the relative motion.
    const Vec3 distance = (m.radius_a + m.radius_b) * m.normal + (gap / m.speed) * relative;
    engine.insert({{{}, m.radius_a, drift + (mass_b / (mass_a + mass_b)) * relative, m.spin_a},
                   {distance, m.radius_b, drift - (mass_a / (mass_a + mass_b)) * relative, m.spin_b}});
    engine.step(10000); // 2.5 elastic durations: at e >= 0.5 they have parted
    if (engine.state().contacts != 0) throw std::runtime_error("the spheres have not parted");
    const auto v = engine.velocities();
    const auto w = engine.spins();
    const double impulse = pair.mass * dot(relative - (v[0] - v[1]), m.normal);
    return {v[0], v[1], w[0], w[1], impulse / duration, engine.internal_force_sum().second};
}

Vec3 cross(const Vec3& a, const Vec3& b) { return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}; }

TEST(SlidingImpact, of_unequal_spheres_reverses_the_slip_by_coulombs_share) {
    Encounter m{};
    m.radius_a = 1.0e-3;
    m.radius_b = 2.5e-3;
    m.speed = 0.004; // slow: the contact lasts for 3e-5 of the way a sphere needs for its radius, so the normal hardly turns
    m.friction = 0.1;
    const Vec3 tangent{3.0 / 7.0, -6.0 / 7.0, 2.0 / 7.0};
    for (const double restitution : {0.5, 0.8, 1.0}) {
        m.restitution = restitution;
        for (const double share : {0.25, 0.6, 0.9}) { // of the slip that is left, 1 - 3.5 mu (1 + e) vn / vst
            const double slip = 3.5 * m.friction * (1.0 + restitution) * m.speed / (1.0 - share);
            // A tenth of the slip by velocity, the rest by spins that differ: the surface of a is at +R_a n.
            m.slip = (0.1 * slip) * tangent;
            m.spin_a = (0.7 * slip / m.radius_a) * cross(m.normal, tangent);
            m.spin_b = (0.2 * slip / m.radius_b) * cross(m.normal, tangent);
            const Parting p = meet(m, TALUS_TANGENTIAL_FORCE_RESCALED);
            const Vec3 relative = p.velocity_a - p.velocity_b;
            const double parting = -dot(relative, m.normal);
            const Vec3 surface = cross(m.radius_a * p.spin_a + m.radius_b * p.spin_b, m.normal);
            const double slip_after = dot(relative + surface, tangent);
            const double impulse = m.friction * (m.speed + parting); // per m*
            // Restitution within 1e-4 at 4000 steps (test_impact). The slip follows from the impulse that was measured; the
            // figures are taken along the first touch while the normal turns by 1e-5 in the contact: 1e-4 is ample for both.
            EXPECT_NEAR(parting / m.speed, restitution, 1e-4) << "left " << share;
            EXPECT_NEAR(slip_after / slip, 1.0 - 3.5 * impulse / slip, 1e-5) << "e = " << restitution << ", left " << share;
            EXPECT_NEAR(slip_after / slip, share, 1e-4) << "e = " << restitution;
            // The same tangential impulse at the lever of each: changes of spin as 1/(m R), parallel, whatever the turn.
            const Vec3 change_a = p.spin_a - m.spin_a;
            const Vec3 change_b = p.spin_b - m.spin_b;
            const double levers = (kAlloy.mass(m.radius_b) * m.radius_b) / (kAlloy.mass(m.radius_a) * m.radius_a);
            // So slow an impact of so stiff spheres has forces of 1e-8 of the cap: the rounding to units is seen. If all rounded to
            // one side: a unit of torque (that of forces times the largest radius, to a power of two) against the mean torque.
            const double rounding = 2.0 * p.unit * m.radius_b / (m.friction * p.mean_force * m.radius_a);
            EXPECT_LE(rounding, 1e-5);
            EXPECT_NEAR(length(change_a) / length(change_b) / levers, 1.0, rounding);
            EXPECT_NEAR(dot(change_a, change_b) / (length(change_a) * length(change_b)), 1.0, rounding * rounding + 1e-14);
        }
    }
}

TEST(SpinningImpact, of_equal_spheres_with_opposite_spins_leaves_the_spins_alone) {
    Encounter m{};
    m.radius_a = m.radius_b = 1.0e-3;
    m.speed = 0.2;
    m.friction = 0.4;
    m.restitution = 0.7;
    for (const Vec3& spin : {Vec3{300.0, -200.0, 100.0}, Vec3{0.0, 0.0, 500.0}}) {
        m.spin_a = spin;
        m.spin_b = -1.0 * spin;
        for (const int32_t tangential : {TALUS_TANGENTIAL_FORCE_RESCALED, TALUS_TANGENTIAL_FORCE, TALUS_TANGENTIAL_DISPLACEMENT}) {
            const Parting p = meet(m, tangential);
            // Rolling on each other without slip: no tangential force, to round-off of the velocities (1e-16 of the surface
            // speed of 0.5 m/s) against the normal speed of 0.2 m/s.
            EXPECT_LE(length(p.spin_a - m.spin_a), 1e-9 * length(spin));
            EXPECT_LE(length(p.spin_b - m.spin_b), 1e-9 * length(spin));
            const Vec3 relative = p.velocity_a - p.velocity_b;
            const Vec3 across = relative - dot(relative, m.normal) * m.normal;
            EXPECT_LE(length(across), 1e-9 * m.speed);
        }
    }
}

// ---- Energy ----------------------------------------------------------------------------------------------------------

constexpr double kSweepFriction[] = {0.1, 0.6, 2.0};
constexpr double kSweepSpeed = 0.01; // normal

/// Every angle to grazing, spins forwards, backwards, across and about the normal; all with one normal speed, so that all
/// contacts last alike.
BounceScene sweep_scene(int32_t normal, int32_t tangential, double steps) {
    BounceScene scene;
    scene.laws.normal = normal;
    scene.laws.tangential = tangential;
    scene.laws.stiffness_n = 100.0;
    scene.kinds.clear();
    for (const double restitution : {0.2, 0.5, 0.9, 1.0})
        for (const double friction : kSweepFriction) {
            for (const double degree : {0.0, 3.0, 10.0, 20.0, 24.0, 30.0, 37.0, 45.0, 56.0, 65.0, 75.0, 85.0, 89.0, 89.9}) {
                const double vt = kSweepSpeed * std::tan(radians(degree));
                const double rate = std::hypot(vt, kSweepSpeed) / kSandRadius;
                for (const Vec3& spin : {Vec3{0.0, 0.0, 0.0}, Vec3{0.0, 0.0, -3.0}, Vec3{0.0, 0.0, -1.0}, Vec3{0.0, 0.0, -0.3},
                                         Vec3{0.0, 0.0, 0.3}, Vec3{0.0, 0.0, 3.0}, Vec3{1.0, 0.0, 0.0}, Vec3{0.5, 0.5, 0.5}})
                    scene.launches.push_back({{vt, -kSweepSpeed, 0.0}, rate * spin, static_cast<int32_t>(scene.kinds.size()), 1.37});
            }
            scene.kinds.push_back({restitution, friction});
        }
    const HertzPair pair = HertzPair::on_rigid_wall(kSand, kSandRadius);
    const double duration =
        normal == TALUS_NORMAL_LINEAR ? kPi * std::sqrt(pair.mass / scene.laws.stiffness_n) : pair.duration(kSweepSpeed);
    scene.time_step = duration / steps;
    return scene;
}

/// Largest relative gain of kinetic energy over all launches.
double largest_gain(const BounceScene& scene) {
    const auto landings = bounce(scene);
    double largest = -1.0;
    for (std::size_t i = 0; i < landings.size(); ++i) {
        const double before = energy_per_mass(scene.launches[i].velocity, scene.launches[i].spin, scene.radius);
        const double after = energy_per_mass(landings[i].velocity, landings[i].spin, scene.radius);
        largest = std::max(largest, after / before - 1.0);
    }
    return largest;
}

TEST(EnergySweep, no_impact_gains_energy_in_the_default_law) {
    // Only an elastic normal impact can keep all energy; Verlet gives it back to 2e-8 at 1000 steps (order 2.5, test_impact).
    EXPECT_LE(largest_gain(sweep_scene(TALUS_NORMAL_HERTZ, TALUS_TANGENTIAL_FORCE_RESCALED, 1000.0)), 5e-8);
    // At 15 steps a contact the same error is 0.09 % of the speed (test_impact prints it), 0.2 % of the energy.
    EXPECT_LE(largest_gain(sweep_scene(TALUS_NORMAL_HERTZ, TALUS_TANGENTIAL_FORCE_RESCALED, 15.0)), 2e-3);
}

TEST(EnergySweep, no_impact_gains_energy_in_the_linear_law) {
    for (const int32_t tangential : {TALUS_TANGENTIAL_FORCE_RESCALED, TALUS_TANGENTIAL_FORCE, TALUS_TANGENTIAL_DISPLACEMENT})
        EXPECT_LE(largest_gain(sweep_scene(TALUS_NORMAL_LINEAR, tangential, 1000.0)), 5e-8);
}

/// The largest gain at e = 1 is found where the slip alone decides it: for a given slip u the least energy is that of
/// v = 2u/7, R w = -5u/7.
double supremum(int32_t tangential, double friction, bool with_spin) {
    const double vn = 0.1;
    BounceScene scene;
    scene.laws.tangential = tangential;
    scene.kinds = {{1.0, friction}};
    for (double slip = 0.02; slip < 8.0 * friction; slip *= 1.01) {
        const double velocity = with_spin ? 2.0 / 7.0 * slip : slip;
        scene.launches.push_back({{velocity * vn, -vn, 0.0}, {0.0, 0.0, (slip - velocity) * vn / kSandRadius}, 0, 1.37});
    }
    scene.time_step = HertzPair::on_rigid_wall(kSand, kSandRadius).duration(vn) / 1000.0;
    return largest_gain(scene);
}

TEST(EnergySweep, displacement_history_gains_what_its_stored_displacement_gives_and_no_more) {
    // Figures of the independent integration for the paper's sand (nu 0.2), the same at 4000 and 20000 steps: 0.294 % without
    // spin and 0.334 % with the worst spin at mu 0.6 (24 degrees); 1.21 % and 2.38 % at mu 2 (56 degrees). The grid of slips
    // (1 %) misses the flat maximum by less than 1 % of it. (physics.md: 0.2 % and 1.8 %, from a coarser sweep.)
    EXPECT_NEAR(supremum(TALUS_TANGENTIAL_DISPLACEMENT, 0.6, false), 2.94e-3, 0.03e-3);
    EXPECT_NEAR(supremum(TALUS_TANGENTIAL_DISPLACEMENT, 0.6, true), 3.34e-3, 0.03e-3);
    EXPECT_NEAR(supremum(TALUS_TANGENTIAL_DISPLACEMENT, 2.0, false), 1.21e-2, 0.01e-2);
    EXPECT_NEAR(supremum(TALUS_TANGENTIAL_DISPLACEMENT, 2.0, true), 2.38e-2, 0.02e-2);
}

TEST(EnergySweep, force_history_without_rescaling_gains_a_few_parts_in_a_hundred_thousand) {
    // physics.md: 0.003 %; 3.3e-5 at many steps and 3.9e-5 at 1000 (first order in the step).
    EXPECT_LE(supremum(TALUS_TANGENTIAL_FORCE, 2.0, true), 4.0e-5);
    EXPECT_LE(supremum(TALUS_TANGENTIAL_FORCE, 0.6, true), 4.0e-6);
}

TEST(EnergySweep, force_history_with_rescaling_gains_nothing) {
    // At grazing slip and friction 2 the tangential spring is loaded hardest; what is left is the normal bounce, 2e-8.
    EXPECT_LE(supremum(TALUS_TANGENTIAL_FORCE_RESCALED, 2.0, true), 5e-8);
    EXPECT_LE(supremum(TALUS_TANGENTIAL_FORCE_RESCALED, 0.6, true), 5e-8);
    EXPECT_LE(supremum(TALUS_TANGENTIAL_FORCE_RESCALED, 0.6, false), 5e-8);
}

} // namespace
} // namespace talus::test
