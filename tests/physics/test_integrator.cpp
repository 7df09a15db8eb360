// Velocity Verlet: exact on a projectile, second order on a spring, and a contact's memory carried round with its pair.
// physics.md sections 3 and 5.

#include "../support/engine.hpp"
#include "../support/theory.hpp"

#include <gtest/gtest.h>

namespace talus::test {
namespace {

constexpr Solid kSolid{1.0e7, 0.2, 2600.0};
constexpr double kRadius = 1.0e-3;

Vec3 cross(const Vec3& a, const Vec3& b) { return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}; }

TEST(Projectile, flies_on_its_parabola_to_round_off) {
    const double time_step = 1.0e-5;
    const Vec3 gravity{1.5, -9.0, 4.0};
    const Vec3 start{0.01, 0.02, -0.03};
    const Vec3 velocity{0.3, 0.7, -0.2};
    const Vec3 spin{12.0, -7.0, 30.0};
    talus_settings settings = bare_settings({-1.0, -1.0, -1.0}, {1.0, 1.0, 1.0}, time_step);
    for (std::size_t axis = 0; axis < 3; ++axis) settings.gravity[axis] = gravity[axis];
    Engine engine(settings);
    const int32_t stone = engine.material(kSolid.young, kSolid.poisson, kSolid.density);
    engine.contact(stone, stone, 0.5, 0.5);
    engine.insert({{start, kRadius, velocity, spin}});
    const int steps = 10000;
    engine.step(steps);
    const double time = steps * time_step;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        // Constant acceleration is integrated exactly; 20000 half kicks of the same size round by up to 1.1e-16 of 1 m/s each, at
        // worst all to one side.
        EXPECT_NEAR(engine.positions()[0][axis], start[axis] + velocity[axis] * time + 0.5 * gravity[axis] * time * time, 2e-12 * time);
        EXPECT_NEAR(engine.velocities()[0][axis], velocity[axis] + gravity[axis] * time, 2e-12);
    }
    EXPECT_EQ(engine.spins()[0], spin);
}

/// Height over its resting place of a ball that swings on a linear elastic floor without leaving it, in units of the swing.
double swing(double steps_a_period, int64_t steps) {
    const double mass = kSolid.mass(kRadius);
    const double gravity = 9.81;
    const double stiffness = 150.0; // 20 steps a period are then below Rayleigh's step
    const double rest = mass * gravity / stiffness;
    const double amplitude = 0.5 * rest;
    const double period = 2.0 * kPi * std::sqrt(mass / stiffness);
    talus_settings settings = bare_settings({-0.01, -0.01, -0.01}, {0.01, 0.01, 0.01}, period / steps_a_period);
    settings.gravity[1] = -gravity;
    settings.laws.normal = TALUS_NORMAL_LINEAR;
    settings.laws.stiffness_n = stiffness;
    Engine engine(settings);
    const int32_t ball = engine.material(kSolid.young, kSolid.poisson, kSolid.density);
    const int32_t floor = engine.rigid_material();
    engine.contact(ball, ball, 1.0, 0.0);
    engine.contact(ball, floor, 1.0, 0.0);
    engine.wall(floor, {0.0, 0.0, 0.0}, {0.0, 1.0, 0.0});
    engine.insert({{{0.0, kRadius - rest - amplitude, 0.0}, kRadius}});
    engine.step(steps);
    return (engine.positions()[0][1] - (kRadius - rest)) / amplitude;
}

TEST(Spring, is_integrated_by_verlets_own_solution) {
    // From rest Verlet's recurrence has the solution cos(n phi), cos(phi) = 1 - (w dt)^2/2: no amplitude error, ever.
    for (const double steps_a_period : {20.0, 100.0, 1000.0}) {
        const double wdt = 2.0 * kPi / steps_a_period;
        const double phi = 2.0 * std::asin(0.5 * wdt);
        for (const int64_t steps : {7, 333, 20000})
            // The swing of 0.4 micrometre is the difference of heights near 1 mm: 3e-13 of it for each rounding, some hundred
            // times at random; the unit of forces, 1e-15 N against 1e-4 N, is below.
            EXPECT_NEAR(swing(steps_a_period, steps), -std::cos(static_cast<double>(steps) * phi), 1e-9)
                << steps << " steps of " << steps_a_period << " a period";
    }
}

TEST(Spring, shows_second_order) {
    // Three periods and an eighth, where the phase error shows in full slope.
    const auto error = [](int64_t steps_a_period) {
        const int64_t steps = 3 * steps_a_period + steps_a_period / 8;
        return swing(static_cast<double>(steps_a_period), steps) + std::cos(2.0 * kPi * 3.125);
    };
    // The phase error is (w dt)^2/24; its own relative error of order (w dt)^2 is 4e-3 at 104 steps.
    EXPECT_NEAR(observed_order(error(104), error(208), 2.0), 2.0, 0.02);
    EXPECT_NEAR(observed_order(error(208), error(416), 2.0), 2.0, 0.005);
    const double wdt = 2.0 * kPi / 416.0;
    const double phase = 2.0 * kPi * 3.125;
    EXPECT_NEAR(error(416) / (std::sin(phase) * phase * wdt * wdt / 24.0), 1.0, 0.01);
}

// ---- A pair that turns as one body -----------------------------------------------------------------------------------
//
// Two driven grains in touch, steered step by step along exact circles about their middle. The law sees the velocities of the
// middle of the step and the normal of its end, so the spin that rolls without slip is that of the chord.

class TurningPair {
public:
    TurningPair(int32_t tangential, double sheared) : engine_(settings(tangential)) {
        const int32_t sand = engine_.material(kSolid.young, kSolid.poisson, kSolid.density);
        engine_.contact(sand, sand, 1.0, 10.0); // friction that never slides
        engine_.insert({{{-0.5 * kDistance, 0.0, 0.0}, kRadius, {}, {}, sand, 2}, {{0.5 * kDistance, 0.0, 0.0}, kRadius, {}, {}, sand, 3}});
        const int steps = 20;
        for (int i = 0; i < steps; ++i) drive({}, (sheared / (steps * kStep)) * Vec3{0.0, 0.6, 0.8}, {});
        drive({}, {}, {}); // the force of a pair at rest
        const auto x = engine_.positions();
        middle_ = 0.5 * (x[0] + x[1]);
    }

    /// Turn by `angle` about `axis` in `steps`. With `chord` the spin is the one without slip, else the rate of the turn.
    void turn(const Vec3& axis, double angle, int steps, bool chord) {
        const Vec3 arm = engine_.positions()[0] - middle_;
        const double distance = 2.0 * length(arm);
        for (int i = 0; i < steps; ++i) {
            const Vec3 to = rotated(arm, axis, angle * (i + 1) / steps);
            const auto x = engine_.positions();
            const Vec3 velocity_a = (1.0 / kStep) * (middle_ + to - x[0]);
            const Vec3 velocity_b = (1.0 / kStep) * (middle_ - to - x[1]);
            Vec3 spin = (angle / (steps * kStep) * distance / (2.0 * kRadius)) * axis;
            if (chord) {
                const Vec3 normal = (1.0 / length(to)) * to;
                spin = (1.0 / (2.0 * kRadius)) * cross(normal, velocity_a - velocity_b);
            }
            drive(velocity_a, velocity_b, spin);
        }
    }

    Vec3 tangential_force() {
        const auto x = engine_.positions();
        const Vec3 normal = (1.0 / length(x[0] - x[1])) * (x[0] - x[1]);
        const Vec3 force = engine_.forces()[0];
        return force - dot(force, normal) * normal;
    }
    /// The direction across the line of centres nearest to z.
    Vec3 upright() {
        const Vec3 arm = engine_.positions()[0] - middle_;
        const Vec3 across = Vec3{0.0, 0.0, 1.0} - (arm[2] / dot(arm, arm)) * arm;
        return (1.0 / length(across)) * across;
    }
    double distance() {
        const auto x = engine_.positions();
        return length(x[0] - x[1]);
    }

    static Vec3 rotated(const Vec3& v, const Vec3& axis, double angle) {
        return std::cos(angle) * v + std::sin(angle) * cross(axis, v) + ((1.0 - std::cos(angle)) * dot(axis, v)) * axis;
    }

    static constexpr double kStep = 1.0e-5;
    static constexpr double kOverlap = 1.0e-5;
    static constexpr double kDistance = 2.0 * kRadius - kOverlap;

private:
    static talus_settings settings(int32_t tangential) {
        talus_settings settings = bare_settings({-0.01, -0.01, -0.01}, {0.01, 0.01, 0.01}, kStep);
        settings.laws.tangential = tangential;
        settings.laws.tangential_damping = 0;
        return settings;
    }
    void drive(const Vec3& velocity_a, const Vec3& velocity_b, const Vec3& spin) {
        engine_.group(2, TALUS_GROUP_DRIVEN, velocity_a, spin);
        engine_.group(3, TALUS_GROUP_DRIVEN, velocity_b, spin);
        engine_.step(1);
    }
    Engine engine_;
    Vec3 middle_{};
};

class TurningPairOf : public testing::TestWithParam<int32_t> {};

TEST_P(TurningPairOf, keeps_the_length_of_its_force_to_round_off) {
    const double slant = std::sqrt(0.5);
    for (const Vec3& axis : {Vec3{0.0, 0.0, 1.0}, Vec3{0.6, 0.0, 0.8}, Vec3{2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0}, Vec3{slant, slant, 0.0}}) {
        TurningPair pair(GetParam(), 1.0e-6);
        const double before = length(pair.tangential_force());
        pair.turn(axis, 2.0 * kPi, 300, true);
        // 300 turns of a vector round by 1e-16 each. A step changes the overlap by 1e-16 m of 1e-5: the rescaled history gives
        // away such parts whenever the contact shrinks, 300 times 1e-11/2; so does the stiffness of the displacement's.
        EXPECT_NEAR(length(pair.tangential_force()) / before, 1.0, 2e-9);
    }
}

TEST_P(TurningPairOf, brings_its_force_round_to_first_order_in_direction) {
    // Projecting on the new tangent plane and stretching to the old length turns the vector within the plane by
    // sin(2a) phi^2/4 a step, a its angle from the plane of the turn: theta phi sin(2a)/4 over a turn of theta. tan a = 0.8/0.6.
    const double turn = 2.0 * kPi;
    for (const int steps : {200, 800}) {
        TurningPair pair(GetParam(), 1.0e-6);
        const Vec3 before = pair.tangential_force();
        pair.turn(pair.upright(), turn, steps, true); // a slant would add the angle of its cone
        const double direction = length(pair.tangential_force() - before) / length(before);
        const double expected = turn * (turn / steps) / 4.0 * 0.96;
        // The angle a itself moves on the way, by 0.05 at 200 steps, and sin(2a) with it.
        EXPECT_NEAR(direction / expected, 1.0, expected + 1e-3) << steps << " steps";
    }
}

TEST_P(TurningPairOf, slips_by_its_chord_to_second_order_when_spun_at_the_rate_of_the_turn) {
    // A turn by phi in a step has the chord velocity r sin(phi)/dt along the end's tangent against r phi/dt of the spin: a slip
    // of r phi^3/6 a step, so a spurious force of kt r theta phi^2/6.
    const HertzPair pair_theory = HertzPair::equal_spheres(kSolid, kRadius);
    const double turn = 2.0 * kPi;
    for (const int steps : {200, 400, 800}) {
        TurningPair pair(GetParam(), 0.0);
        pair.turn(pair.upright(), turn, steps, false);
        const double phi = turn / steps;
        const double stiffness = pair_theory.tangential_stiffness(2.0 * kRadius - pair.distance());
        const double expected = stiffness * pair.distance() * turn * phi * phi / 6.0;
        // Next order phi^2/20; rescaling as above.
        EXPECT_NEAR(length(pair.tangential_force()) / expected, 1.0, phi * phi + 1e-8) << steps << " steps";
    }
}

INSTANTIATE_TEST_SUITE_P(Histories, TurningPairOf,
                         testing::Values(TALUS_TANGENTIAL_FORCE_RESCALED, TALUS_TANGENTIAL_FORCE, TALUS_TANGENTIAL_DISPLACEMENT));

} // namespace
} // namespace talus::test
