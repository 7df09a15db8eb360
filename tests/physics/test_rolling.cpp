// A ball on a plane: sliding into rolling, rolling down an incline, and the two rolling resistances.
// physics.md sections 4 and 6.
//
// The ball starts at the overlap at which the floor carries it, so that the normal force stays m g to the rounding of
// forces (3e-13 N of 1e-2 N). The angular momentum about the point of touch is then exact whatever the tangential spring
// does, and once that spring has come to rest the closed forms hold to round-off: hence the tolerances of 1e-8.

#include "../support/engine.hpp"
#include "../support/theory.hpp"

#include <gtest/gtest.h>

#include <complex>

namespace talus::test {
namespace {

constexpr Solid kBall{1.0e7, 0.25, 2500.0};
constexpr double kRadius = 5.0e-3;
constexpr double kGravity = 9.81;
constexpr double kStep = 4.0e-5; // a tenth of Rayleigh's
constexpr double kTight = 1.0e-8;

struct Slope {
    double angle = 0.0; // downwards in +x
    double friction = 0.3;
    double rolling_friction = 0.0;
    double restitution = 0.2; // its tangential damping brings the spring to rest within milliseconds
    double speed = 0.0;       // at the start, along x
    double spin = 0.0;        // at the start, about z; rolling in +x is negative
};

talus_settings slope_settings(const Slope& slope) {
    talus_settings settings = bare_settings({-1.0, -0.02, -0.05}, {6.0, 0.05, 0.05}, kStep);
    settings.gravity[0] = kGravity * std::sin(slope.angle);
    settings.gravity[1] = -kGravity * std::cos(slope.angle);
    return settings;
}

double resting_overlap(const Slope& slope) {
    return HertzPair::on_rigid_wall(kBall, kRadius).overlap_under(kBall.mass(kRadius) * kGravity * std::cos(slope.angle));
}

Engine ball_on_slope(const Slope& slope, const talus_settings& settings) {
    Engine engine(settings);
    const int32_t ball = engine.material(kBall.young, kBall.poisson, kBall.density);
    const int32_t floor = engine.rigid_material();
    engine.contact(ball, ball, slope.restitution, slope.friction);
    engine.contact(ball, floor, slope.restitution, slope.friction, slope.rolling_friction);
    engine.wall(floor, {0.0, 0.0, 0.0}, {0.0, 1.0, 0.0});
    engine.insert({{{0.0, kRadius - resting_overlap(slope), 0.0}, kRadius, {slope.speed, 0.0, 0.0}, {0.0, 0.0, slope.spin}}});
    return engine;
}

int64_t steps_in(double time) { return static_cast<int64_t>(std::llround(time / kStep)); }

// ---- No resistance to rolling ----------------------------------------------------------------------------------------

TEST(SlidingBall, slows_by_friction_then_rolls_at_five_sevenths) {
    const Slope slope{.speed = 0.5};
    Engine engine = ball_on_slope(slope, slope_settings(slope));
    const double until = 2.0 * slope.speed / (7.0 * slope.friction * kGravity);
    for (const double part : {0.25, 0.5, 0.75, 0.98}) {
        const int64_t target = steps_in(part * until);
        engine.step(target - engine.state().step);
        const double time = static_cast<double>(target) * kStep;
        EXPECT_NEAR(engine.velocities()[0][0] / slope.speed, 1.0 - slope.friction * kGravity * time / slope.speed, kTight);
        EXPECT_NEAR(engine.spins()[0][2] * kRadius / slope.speed, -2.5 * slope.friction * kGravity * time / slope.speed, kTight);
    }
    // What is left of the slip decays with a time of 0.5 ms: 1e-10 after another quarter, 12 ms.
    engine.step(steps_in(1.25 * until) - engine.state().step);
    EXPECT_NEAR(engine.velocities()[0][0] / slope.speed, 5.0 / 7.0, kTight);
    EXPECT_NEAR(engine.spins()[0][2] * kRadius / slope.speed, -5.0 / 7.0, kTight);
    engine.step(1000);
    EXPECT_NEAR(engine.velocities()[0][0] / slope.speed, 5.0 / 7.0, kTight) << "rolling on must cost nothing";
}

TEST(BallOnAnIncline, rolls_at_five_sevenths_of_the_pull_while_friction_can_turn_it) {
    for (const double degrees : {10.0, 30.0, 45.0}) { // tan 45 = 1 < 3.5 mu = 1.05
        const Slope slope{.angle = degrees * kPi / 180.0};
        Engine engine = ball_on_slope(slope, slope_settings(slope));
        for (const int64_t steps : {1000, 4000}) {
            engine.step(steps - engine.state().step);
            const double expected = 5.0 / 7.0 * kGravity * std::sin(slope.angle) * static_cast<double>(steps) * kStep;
            EXPECT_NEAR(engine.velocities()[0][0] / expected, 1.0, kTight) << degrees << " degrees";
            EXPECT_NEAR(-engine.spins()[0][2] * kRadius / expected, 1.0, kTight) << degrees << " degrees";
        }
    }
}

TEST(BallOnAnIncline, slides_when_it_is_steeper) {
    const Slope slope{.angle = kPi / 3.0}; // tan 60 = 1.73 > 1.05
    Engine engine = ball_on_slope(slope, slope_settings(slope));
    engine.step(1000); // past the moment in which the spring loads to the cap
    const double velocity = engine.velocities()[0][0];
    const double spin = engine.spins()[0][2];
    engine.step(2000);
    const double time = 2000.0 * kStep;
    const double pull = kGravity * (std::sin(slope.angle) - slope.friction * std::cos(slope.angle));
    const double turning = 2.5 * slope.friction * kGravity * std::cos(slope.angle) / kRadius;
    EXPECT_NEAR((engine.velocities()[0][0] - velocity) / (pull * time), 1.0, kTight);
    EXPECT_NEAR(-(engine.spins()[0][2] - spin) / (turning * time), 1.0, kTight);
}

// ---- Type A: constant torque -----------------------------------------------------------------------------------------

talus_settings constant_torque(const Slope& slope, double rate) {
    talus_settings settings = slope_settings(slope);
    settings.laws.rolling = TALUS_ROLLING_CONSTANT;
    settings.laws.rolling_rate = rate;
    return settings;
}

TEST(ConstantRolling, stops_a_ball_on_a_plane_after_its_distance) {
    const double speed = 0.1;
    const Slope slope{.rolling_friction = 0.05, .speed = speed, .spin = -speed / kRadius};
    const double rate = 0.05;
    Engine engine = ball_on_slope(slope, constant_torque(slope, rate));
    const double brake = 5.0 / 7.0 * slope.rolling_friction * kGravity;
    const double stop_time = speed / brake;
    for (const double part : {0.25, 0.5, 0.9}) {
        const int64_t target = steps_in(part * stop_time);
        engine.step(target - engine.state().step);
        EXPECT_NEAR(engine.velocities()[0][0] / speed, 1.0 - brake * static_cast<double>(target) * kStep / speed, kTight);
    }
    // Below `rate` the torque falls with the rate: it stops exponentially over twice the distance that is left by then,
    // which adds (R rate / v0)^2 = 6e-6 to the distance of physics.md. While it brakes, the tangential spring is stretched by
    // f/kt, f = m a; the roll lags by 5/7 of that: 8e-6 less. What is left is the step in the tail: 4e-7.
    engine.step(steps_in(1.5 * stop_time) - engine.state().step);
    const double distance = 7.0 * speed * speed / (10.0 * slope.rolling_friction * kGravity);
    const double slow = kRadius * rate / speed;
    const double stretch =
        kBall.mass(kRadius) * brake / HertzPair::on_rigid_wall(kBall, kRadius).tangential_stiffness(resting_overlap(slope));
    EXPECT_NEAR(engine.positions()[0][0] / distance, 1.0, 1e-5);
    EXPECT_NEAR(engine.positions()[0][0] / distance, 1.0 + slow * slow - 5.0 / 7.0 * stretch / distance, 1e-6);
    EXPECT_LE(std::fabs(engine.velocities()[0][0]), 1e-8 * speed);
}

TEST(ConstantRolling, creeps_down_a_gentle_slope_at_the_documented_rate) {
    const double rate = 0.05;
    for (const double share : {0.1, 0.5, 0.9}) {
        const double rolling_friction = 0.05;
        const Slope slope{.angle = std::atan(share * rolling_friction), .rolling_friction = rolling_friction};
        Engine engine = ball_on_slope(slope, constant_torque(slope, rate));
        engine.step(2000); // 80 ms; the creep is reached with a time of R rate/(5/7 mur g) = 0.7 ms
        EXPECT_NEAR(-engine.spins()[0][2] / rate, share, 1e-7);
        EXPECT_NEAR(engine.velocities()[0][0] / (kRadius * rate), share, 1e-7);
    }
}

TEST(ConstantRolling, at_the_default_rate_creeps_no_faster_than_the_rate_and_a_step_of_torque) {
    // At the default rate of 1e-3 rad/s one step of full torque changes the spin of this ball by 10 times the rate: the
    // explicit step cannot resolve the ramp, the ball trembles and creeps by up to that change instead of the rate.
    const Slope slope{.angle = std::atan(0.5 * 0.05), .rolling_friction = 0.05};
    talus_settings settings = slope_settings(slope);
    settings.laws.rolling = TALUS_ROLLING_CONSTANT;
    Engine engine = ball_on_slope(slope, settings);
    engine.step(1000);
    const double from = engine.positions()[0][0];
    engine.step(25000); // one second
    const double step_of_torque = 2.5 * slope.rolling_friction * kGravity / kRadius * kStep;
    const double seconds = 25000.0 * kStep;
    EXPECT_LE(std::fabs(engine.positions()[0][0] - from) / (kRadius * seconds), settings.laws.rolling_rate + step_of_torque);
    EXPECT_LE(std::fabs(engine.spins()[0][2]), settings.laws.rolling_rate + step_of_torque);
}

TEST(ConstantRolling, lets_a_ball_roll_where_the_slope_is_steeper) {
    const Slope slope{.angle = std::atan(0.2), .rolling_friction = 0.05};
    Engine engine = ball_on_slope(slope, constant_torque(slope, 0.05));
    engine.step(1000);
    const double velocity = engine.velocities()[0][0];
    engine.step(2000);
    const double pull = 5.0 / 7.0 * kGravity * (std::sin(slope.angle) - slope.rolling_friction * std::cos(slope.angle));
    EXPECT_NEAR((engine.velocities()[0][0] - velocity) / (pull * 2000.0 * kStep), 1.0, kTight);
}

TEST(ConstantRolling, has_the_effective_radius_or_each_grains_own) {
    const double radius_a = 3.0e-3;
    const double radius_b = 5.0e-3;
    const double overlap = 1.0e-5;
    const double rolling_friction = 0.1;
    HertzPair pair = HertzPair::equal_spheres(kBall, 1.0);
    pair.radius = radius_a * radius_b / (radius_a + radius_b);
    const double normal_force = pair.stiffness() * std::pow(overlap, 1.5);
    for (const int32_t convention : {TALUS_ROLLING_RADIUS_EFFECTIVE, TALUS_ROLLING_RADIUS_OWN}) {
        talus_settings settings = bare_settings({-0.05, -0.05, -0.05}, {0.05, 0.05, 0.05}, kStep);
        settings.laws.tangential = TALUS_TANGENTIAL_NONE;
        settings.laws.rolling = TALUS_ROLLING_CONSTANT;
        settings.laws.rolling_radius = convention;
        Engine engine(settings);
        const int32_t ball = engine.material(kBall.young, kBall.poisson, kBall.density);
        engine.contact(ball, ball, 0.5, 0.3, rolling_friction);
        // The spin about x, along the line of centres, must not count.
        engine.insert({{{0.0, 0.0, 0.0}, radius_a, {}, {7.0, 3.0, 4.0}},
                       {{radius_a + radius_b - overlap, 0.0, 0.0}, radius_b, {}, {-2.0, 0.0, 0.0}}});
        engine.step();
        const bool own = convention == TALUS_ROLLING_RADIUS_OWN;
        const double on_a = rolling_friction * normal_force * (own ? radius_a : pair.radius);
        const double on_b = rolling_friction * normal_force * (own ? radius_b : pair.radius);
        const auto torques = engine.torques();
        const Vec3 direction{0.0, 0.6, 0.8}; // of the relative spin across the line of centres
        // One evaluation of the law; overlap = Ri + Rj - distance carries the rounding of the distance, 1e-18/1e-5, times 1.5, and
        // the sum its unit: that of forces times the largest radius, to the next power of two.
        const double rounding = 2.0 * radius_b * engine.internal_force_sum().second;
        EXPECT_LE(rounding, 1e-8 * on_a);
        EXPECT_LE(length(torques[0] + on_a * direction), 1e-11 * on_a + rounding);
        EXPECT_LE(length(torques[1] - on_b * direction), 1e-11 * on_b + rounding);
    }
}

// ---- Type C: elastic-plastic spring and dashpot ----------------------------------------------------------------------

talus_settings spring_rolling(const Slope& slope, double damping) {
    talus_settings settings = slope_settings(slope);
    settings.laws.rolling = TALUS_ROLLING_SPRING;
    settings.laws.rolling_damping = damping;
    return settings;
}

/// The two springs of a ball that holds: the roll's and the tangential one.
struct HoldingBall {
    double normal_secant, roll, tangential, dashpot, mass, inertia;
    explicit HoldingBall(const Slope& slope) {
        const HertzPair pair = HertzPair::on_rigid_wall(kBall, kRadius);
        const double overlap = resting_overlap(slope);
        normal_secant = 4.0 / 3.0 * pair.modulus * pair.contact_radius(overlap);
        roll = 2.25 * normal_secant * std::pow(slope.rolling_friction * kRadius, 2.0);
        tangential = pair.tangential_stiffness(overlap);
        mass = kBall.mass(kRadius);
        inertia = 0.4 * mass * kRadius * kRadius;
        dashpot = 2.0 * std::sqrt(5.0 / 6.0) * attractive_damping_ratio(slope.restitution) * std::sqrt(tangential * mass);
    }
    /// Slow mode of m x'' = -f, I a'' = R f - kr a with f = kt s + c s', s = x - R a: Newton from the mode with f rigid.
    double period() const {
        using Complex = std::complex<double>;
        Complex rate(0.0, std::sqrt(roll / (1.4 * mass * kRadius * kRadius)));
        const double r2 = kRadius * kRadius;
        for (int i = 0; i < 50; ++i) {
            const Complex contact = tangential + dashpot * rate;
            const Complex x = mass * rate * rate + contact;
            const Complex a = inertia * rate * rate + r2 * contact + roll;
            const Complex value = x * a - r2 * contact * contact;
            const Complex slope =
                (2.0 * mass * rate + dashpot) * a + x * (2.0 * inertia * rate + r2 * dashpot) - 2.0 * r2 * contact * dashpot;
            rate -= value / slope;
        }
        return 2.0 * kPi / rate.imag();
    }
    double displacement(double force) const { return force * (kRadius * kRadius / roll + 1.0 / tangential); }
};

TEST(SpringRolling, swings_with_its_period_on_a_slope) {
    for (const double rolling_friction : {0.05, 0.1}) {
        const Slope slope{.angle = std::atan(0.25 * rolling_friction), .rolling_friction = rolling_friction};
        const HoldingBall ball(slope);
        // physics.md's period has a rigid tangential contact: the other spring in series lengthens it by a share of order
        // kr/(kt R^2) = 1.75 mur^2.
        const double stiff = 2.0 * kPi / rolling_friction * std::sqrt(0.6222 * ball.mass / ball.normal_secant);
        EXPECT_NEAR(ball.period() / stiff, 1.0, 1.75 * rolling_friction * rolling_friction);
        EXPECT_GT(ball.period(), stiff);

        Engine engine = ball_on_slope(slope, spring_rolling(slope, 0.0));
        const int64_t most = steps_in(12.0 * ball.period());
        double before = 0.0;
        std::vector<double> turns; // times at which the velocity changes from down to up the slope
        for (int64_t n = 1; n <= most; ++n) {
            engine.step(1);
            const double now = engine.velocities()[0][0];
            if (before > 0.0 && now <= 0.0) turns.push_back((static_cast<double>(n - 1) + before / (before - now)) * kStep);
            before = now;
        }
        ASSERT_GE(turns.size(), 11u);
        // Verlet's phase is (w dt)^2/24 = 2e-6 at mur = 0.1; the turns are cut from a straight line between two steps, good to
        // 1e-3 of a step, 1e-7 of ten periods.
        EXPECT_NEAR((turns[10] - turns[0]) / (10.0 * ball.period()), 1.0, 4e-6);
    }
}

TEST(SpringRolling, holds_a_ball_on_a_slope_for_good) {
    for (const double share : {0.25, 0.9}) {
        const double rolling_friction = 0.1;
        const Slope slope{.angle = std::atan(share * rolling_friction), .rolling_friction = rolling_friction};
        const HoldingBall ball(slope);
        Engine engine = ball_on_slope(slope, spring_rolling(slope, 0.3));
        engine.step(steps_in(30.0 * ball.period())); // decays as exp(-0.3 w t): 1e-24
        const Vec3 rest = engine.positions()[0];
        EXPECT_LE(length(engine.velocities()[0]), 1e-9 * kRadius);
        EXPECT_LE(length(engine.spins()[0]), 1e-9);
        engine.step(10000);
        EXPECT_LE(length(engine.positions()[0] - rest), 1e-9 * kRadius) << "share " << share;
        if (share < 0.5) { // never mobilised: the springs alone say where it comes to rest
            const double pull = ball.mass * kGravity * std::sin(slope.angle);
            EXPECT_NEAR(rest[0] / ball.displacement(pull), 1.0, 1e-7);
        }
    }
}

TEST(SpringRolling, lets_a_ball_roll_where_the_slope_is_steeper) {
    const Slope slope{.angle = std::atan(0.2), .rolling_friction = 0.05};
    Engine engine = ball_on_slope(slope, spring_rolling(slope, 0.3));
    engine.step(2000);
    const double velocity = engine.velocities()[0][0];
    engine.step(2000);
    const double pull = 5.0 / 7.0 * kGravity * (std::sin(slope.angle) - slope.rolling_friction * std::cos(slope.angle));
    EXPECT_NEAR((engine.velocities()[0][0] - velocity) / (pull * 2000.0 * kStep), 1.0, kTight);
}

} // namespace
} // namespace talus::test
