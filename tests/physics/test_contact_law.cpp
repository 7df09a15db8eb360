// One evaluation of the contact law against its formulas, written out here from physics.md sections 2 to 4: two unequal
// grains of unequal materials, driven so that their motion is known, overlapping, sliding and turning in no special direction.
// The first evaluation (step 0) has no history; after one step the history is that of one step.

#include "../support/engine.hpp"
#include "../support/theory.hpp"

#include <gtest/gtest.h>

namespace talus::test {
namespace {

constexpr Solid kSolidA{1.0e7, 0.2, 2600.0};
constexpr Solid kSolidB{3.0e7, 0.35, 7800.0};
constexpr double kRadiusA = 1.0e-3;
constexpr double kRadiusB = 2.0e-3;
constexpr double kStep = 1.0e-6;
constexpr double kStiffness = 5.0e3; // linear law

// One evaluation in other order of operations: 1e-15 a term, but the overlap of 2e-5 m is the difference of lengths of 3e-3 m with
// 4e-19 m of rounding each, 1e-13 of it. Besides, each component is rounded to a unit of the sums.
constexpr double kTight = 1.0e-11;

Vec3 cross(const Vec3& a, const Vec3& b) { return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}; }

struct Motion {
    Vec3 velocity_a{0.02, -0.05, 0.03};
    Vec3 velocity_b{-0.01, 0.01, 0.04};
    Vec3 spin_a{20.0, 5.0, -13.0};
    Vec3 spin_b{-8.0, 11.0, 6.0};
};

struct Law {
    talus_laws laws = bare_settings({}, {}, 0.0).laws;
    double restitution = 0.4;
    double friction = 1.0e3; // no sliding unless asked for
    double rolling_friction = 0.1;
};

/// What the law is made of at the present positions of two grains.
struct Expected {
    Vec3 normal; // from b to a
    double overlap, parting_speed;
    Vec3 slip, rolling_rate;
    HertzPair pair;
    double elastic, normal_damping, stiffness_t, damping_t, secant;

    Expected(const Law& law, const Motion& motion, const std::vector<Vec3>& x) {
        const double distance = length(x[0] - x[1]);
        normal = (1.0 / distance) * (x[0] - x[1]);
        overlap = kRadiusA + kRadiusB - distance;
        const Vec3 relative = motion.velocity_a - motion.velocity_b;
        parting_speed = dot(relative, normal);
        slip = relative - parting_speed * normal - cross(kRadiusA * motion.spin_a + kRadiusB * motion.spin_b, normal);
        rolling_rate = motion.spin_a - motion.spin_b;
        rolling_rate = rolling_rate - dot(rolling_rate, normal) * normal;

        const HertzPair a = HertzPair::on_rigid_wall(kSolidA, kRadiusA);
        const HertzPair b = HertzPair::on_rigid_wall(kSolidB, kRadiusB);
        pair.radius = kRadiusA * kRadiusB / (kRadiusA + kRadiusB);
        pair.mass = a.mass * b.mass / (a.mass + b.mass);
        pair.modulus = 1.0 / (1.0 / a.modulus + 1.0 / b.modulus);
        pair.shear = 1.0 / (1.0 / a.shear + 1.0 / b.shear);

        const double beta = attractive_damping_ratio(law.restitution);
        const double zeta = law.laws.damping == TALUS_DAMPING_CLIPPED ? clipped_damping_ratio(law.restitution) : beta;
        if (law.laws.normal == TALUS_NORMAL_HERTZ) {
            const double radius = pair.contact_radius(overlap);
            elastic = pair.stiffness() * std::pow(overlap, 1.5);
            normal_damping = 2.0 * std::sqrt(5.0 / 6.0) * zeta * std::sqrt(2.0 * pair.modulus * radius * pair.mass);
            stiffness_t = pair.tangential_stiffness(overlap);
            damping_t = 2.0 * std::sqrt(5.0 / 6.0) * beta * std::sqrt(stiffness_t * pair.mass);
            secant = 4.0 / 3.0 * pair.modulus * radius;
        } else {
            elastic = kStiffness * overlap;
            normal_damping = 2.0 * zeta * std::sqrt(kStiffness * pair.mass);
            stiffness_t = law.laws.stiffness_t > 0.0 ? law.laws.stiffness_t : 2.0 / 7.0 * kStiffness;
            damping_t = 2.0 * beta * std::sqrt(stiffness_t * pair.mass);
            secant = kStiffness;
        }
        if (!law.laws.tangential_damping) damping_t = 0.0;
    }
    double normal_force() const { return elastic - normal_damping * parting_speed; }
};

struct Outcome {
    std::vector<Vec3> positions, forces, torques;
    double unit;                                                 // N, of force sums
    double torque_unit() const { return 2.0 * unit * kRadiusB; } // N m, at most: of the cap times the largest radius, to a power of two
};

/// `swapped` gives b the smaller label.
Outcome evaluate(const Law& law, const Motion& motion, int64_t steps, bool swapped) {
    const Vec3 along{2.0 / 7.0, -6.0 / 7.0, 3.0 / 7.0};
    const double overlap = 2.0e-5;
    talus_settings settings = bare_settings({-0.02, -0.02, -0.02}, {0.02, 0.02, 0.02}, kStep);
    settings.laws = law.laws;
    settings.laws.stiffness_n = kStiffness;
    Engine engine(settings);
    const int32_t a = engine.material(kSolidA.young, kSolidA.poisson, kSolidA.density);
    const int32_t b = engine.material(kSolidB.young, kSolidB.poisson, kSolidB.density);
    engine.contact(a, a, 1.0, 0.0);
    engine.contact(b, b, 1.0, 0.0);
    engine.contact(a, b, law.restitution, law.friction, law.rolling_friction);
    const Grain grain_a{{}, kRadiusA, motion.velocity_a, motion.spin_a, a, 2};
    const Grain grain_b{(kRadiusA + kRadiusB - overlap) * along, kRadiusB, motion.velocity_b, motion.spin_b, b, 3};
    engine.insert(swapped ? std::vector<Grain>{grain_b, grain_a} : std::vector<Grain>{grain_a, grain_b});
    engine.group(2, TALUS_GROUP_DRIVEN, motion.velocity_a, motion.spin_a);
    engine.group(3, TALUS_GROUP_DRIVEN, motion.velocity_b, motion.spin_b);
    engine.step(steps);
    Outcome o{engine.positions(), engine.forces(), engine.torques(), engine.internal_force_sum().second};
    if (swapped)
        for (auto* field : {&o.positions, &o.forces, &o.torques}) std::swap((*field)[0], (*field)[1]);
    return o;
}

void expect_equal(const Vec3& seen, const Vec3& expected, double unit, const char* what) {
    EXPECT_LE(length(seen - expected), kTight * length(expected) + unit)
        << what << ": seen " << seen[0] << " " << seen[1] << " " << seen[2] << ", expected " << expected[0] << " " << expected[1] << " "
        << expected[2];
}

std::vector<Law> laws_of_forces() {
    std::vector<Law> all;
    for (const int32_t normal : {TALUS_NORMAL_HERTZ, TALUS_NORMAL_LINEAR})
        for (const int32_t damping : {TALUS_DAMPING_CLIPPED, TALUS_DAMPING_ATTRACTIVE})
            for (const int32_t tangential_damping : {1, 0}) {
                Law law;
                law.laws.normal = normal;
                law.laws.damping = damping;
                law.laws.tangential_damping = tangential_damping;
                all.push_back(law);
            }
    all.back().laws.stiffness_t = 1.7e3; // given instead of 2/7 of the normal one
    return all;
}

TEST(ContactLaw, has_the_forces_of_its_formulas_at_first_sight_and_after_a_step) {
    const Motion motion;
    for (const Law& base : laws_of_forces())
        for (const int32_t tangential :
             {TALUS_TANGENTIAL_FORCE_RESCALED, TALUS_TANGENTIAL_FORCE, TALUS_TANGENTIAL_DISPLACEMENT, TALUS_TANGENTIAL_NONE})
            for (const bool swapped : {false, true})
                for (const int64_t steps : {0, 1}) {
                    Law law = base;
                    law.laws.tangential = tangential;
                    SCOPED_TRACE(testing::Message()
                                 << "normal " << law.laws.normal << " damping " << law.laws.damping << " tangential " << tangential
                                 << " damped " << law.laws.tangential_damping << " swapped " << swapped << " steps " << steps);
                    const Outcome o = evaluate(law, motion, steps, swapped);
                    const Expected e(law, motion, o.positions);
                    ASSERT_LT(e.parting_speed, 0.0); // approaching
                    const bool frictionless = tangential == TALUS_TANGENTIAL_NONE;
                    const double spring = static_cast<double>(steps) * kStep * e.stiffness_t;
                    const Vec3 across = (frictionless ? 0.0 : -(spring + e.damping_t)) * e.slip;
                    expect_equal(o.forces[0], e.normal_force() * e.normal + across, o.unit, "force");
                    expect_equal(o.forces[1], -1.0 * o.forces[0], o.unit, "reaction");
                    // On a the force acts at -R_a n, on b the opposite one at +R_b n.
                    const Vec3 turn = cross(e.normal, across);
                    if (length(turn) == 0.0) {
                        EXPECT_EQ(length(o.torques[0]) + length(o.torques[1]), 0.0);
                        continue;
                    }
                    expect_equal(o.torques[0], (-kRadiusA) * turn, o.torque_unit(), "torque on the first");
                    expect_equal(o.torques[1], (-kRadiusB) * turn, o.torque_unit(), "torque on the second");
                }
}

TEST(ContactLaw, caps_friction_at_mu_times_the_normal_force) {
    const Motion motion;
    for (const Law& base : laws_of_forces())
        for (const int32_t tangential : {TALUS_TANGENTIAL_FORCE_RESCALED, TALUS_TANGENTIAL_FORCE, TALUS_TANGENTIAL_DISPLACEMENT}) {
            Law law = base;
            law.laws.tangential = tangential;
            law.friction = 1.0e-4; // below what the spring alone reaches in a step
            const Outcome o = evaluate(law, motion, 1, false);
            const Expected e(law, motion, o.positions);
            const Vec3 across = (-law.friction * e.normal_force() / length(e.slip)) * e.slip;
            expect_equal(o.forces[0], e.normal_force() * e.normal + across, o.unit, "force");
        }
}

TEST(ContactLaw, carries_its_history_into_the_next_step) {
    // Parting slowly enough to stay in touch: the contact shrinks, and the three histories differ.
    Motion motion;
    const Vec3 along{2.0 / 7.0, -6.0 / 7.0, 3.0 / 7.0};
    motion.velocity_b = motion.velocity_a + 0.3 * along + Vec3{0.04, 0.01, -0.02};
    for (const int32_t normal : {TALUS_NORMAL_HERTZ, TALUS_NORMAL_LINEAR})
        for (const int32_t tangential : {TALUS_TANGENTIAL_FORCE_RESCALED, TALUS_TANGENTIAL_FORCE, TALUS_TANGENTIAL_DISPLACEMENT})
            for (const bool swapped : {false, true}) {
                SCOPED_TRACE(testing::Message() << "normal " << normal << " tangential " << tangential << " swapped " << swapped);
                Law law;
                law.laws.normal = normal;
                law.laws.tangential = tangential;
                law.restitution = 0.9; // else damping alone would open the contact
                const Outcome first = evaluate(law, motion, 1, swapped);
                const Outcome second = evaluate(law, motion, 2, swapped);
                const Expected e1(law, motion, first.positions);
                const Expected e2(law, motion, second.positions);
                ASSERT_LT(e2.overlap, e1.overlap);
                ASSERT_GT(e2.normal_force(), 0.0);
                // The displacement of the first step, turned into the plane of the second at its length.
                const Vec3 before = kStep * e1.slip;
                const Vec3 projected = before - dot(before, e2.normal) * e2.normal;
                const Vec3 turned = (length(before) / length(projected)) * projected;
                double kept = e1.stiffness_t; // a force that was stored
                if (tangential == TALUS_TANGENTIAL_DISPLACEMENT) kept = e2.stiffness_t;
                if (tangential == TALUS_TANGENTIAL_FORCE_RESCALED) kept *= e2.stiffness_t / e1.stiffness_t; // as the radius (Hertz)
                const Vec3 across = -1.0 * (kept * turned + (e2.stiffness_t * kStep + e2.damping_t) * e2.slip);
                expect_equal(second.forces[0], e2.normal_force() * e2.normal + across, second.unit, "force");
            }
}

TEST(ContactLaw, never_attracts_unless_asked_to) {
    Motion motion;
    // Parting fast enough for damping to outweigh elasticity.
    const Vec3 along{2.0 / 7.0, -6.0 / 7.0, 3.0 / 7.0};
    motion.velocity_b = motion.velocity_a + 1.0 * along;
    for (const Law& law : laws_of_forces()) {
        const Outcome o = evaluate(law, motion, 1, false);
        const Expected e(law, motion, o.positions);
        ASSERT_LT(e.normal_force(), 0.0);
        if (law.laws.damping == TALUS_DAMPING_CLIPPED) {
            EXPECT_EQ(o.forces[0], Vec3{}) << "no normal force, so no friction either";
            EXPECT_EQ(o.torques[0], Vec3{});
        } else {
            EXPECT_NEAR(dot(o.forces[0], e.normal) / e.normal_force(), 1.0, kTight);
        }
    }
}

TEST(ContactLaw, has_the_rolling_spring_and_dashpot_of_its_formulas) {
    const Motion motion;
    for (const int32_t normal : {TALUS_NORMAL_HERTZ, TALUS_NORMAL_LINEAR})
        for (const double damping : {0.3, 0.0})
            for (const bool swapped : {false, true})
                for (const double rolling_friction : {0.5, 1.0e-4}) {
                    Law law;
                    law.laws.normal = normal;
                    law.laws.tangential = TALUS_TANGENTIAL_NONE;
                    law.laws.rolling = TALUS_ROLLING_SPRING;
                    law.laws.rolling_damping = damping;
                    law.rolling_friction = rolling_friction;
                    const Outcome o = evaluate(law, motion, 1, swapped);
                    const Expected e(law, motion, o.positions);
                    const double lever = rolling_friction * e.pair.radius;
                    const double stiffness = 2.25 * e.secant * lever * lever;
                    const double cap = lever * e.normal_force();
                    const double inertia_a = 1.4 * kSolidA.mass(kRadiusA) * kRadiusA * kRadiusA; // about the point of touch
                    const double inertia_b = 1.4 * kSolidB.mass(kRadiusB) * kRadiusB * kRadiusB;
                    const double inertia = 1.0 / (1.0 / inertia_a + 1.0 / inertia_b);
                    const double dashpot = 2.0 * damping * std::sqrt(inertia * stiffness);
                    const double spring = stiffness * kStep * length(e.rolling_rate);
                    const double moment = spring >= cap ? cap : spring + dashpot * length(e.rolling_rate);
                    SCOPED_TRACE(testing::Message() << "normal " << normal << " damping " << damping << " swapped " << swapped << " mur "
                                                    << rolling_friction << (spring >= cap ? " mobilised" : ""));
                    const Vec3 expected = (-moment / length(e.rolling_rate)) * e.rolling_rate;
                    expect_equal(o.torques[0], expected, o.torque_unit(), "torque");
                    expect_equal(o.torques[1], -1.0 * expected, o.torque_unit(), "reaction");
                }
}

TEST(ContactLaw, has_the_constant_torque_of_its_formula) {
    const Motion motion;
    for (const double rate : {1.0e-3, 100.0}) { // below and above the rate of this pair, 30 rad/s
        Law law;
        law.laws.tangential = TALUS_TANGENTIAL_NONE;
        law.laws.rolling = TALUS_ROLLING_CONSTANT;
        law.laws.rolling_rate = rate;
        const Outcome o = evaluate(law, motion, 1, false);
        const Expected e(law, motion, o.positions);
        const double moment = law.rolling_friction * e.pair.radius * e.normal_force();
        const Vec3 expected = (-moment / std::max(length(e.rolling_rate), rate)) * e.rolling_rate;
        expect_equal(o.torques[0], expected, o.torque_unit(), "torque");
        expect_equal(o.torques[1], -1.0 * expected, o.torque_unit(), "reaction");
    }
}

} // namespace
} // namespace talus::test
