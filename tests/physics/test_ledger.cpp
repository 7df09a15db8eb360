// The energy ledger: kinetic + rotational + elastic + gravity + dissipated - work of walls is constant. First against closed
// forms, then in a shearing box for every combination of laws. physics.md section 6, design.md "Physics".

#include "../support/bed.hpp"
#include "../support/engine.hpp"
#include "../support/theory.hpp"

#include <gtest/gtest.h>

#include <cstdio>

namespace talus::test {
namespace {

double stored(const talus_energy& e) {
    return e.kinetic + e.rotational + e.elastic_normal + e.elastic_tangential + e.elastic_rolling + e.gravity;
}
double dissipated(const talus_energy& e) { return e.friction + e.damping + e.rolling; }
double balance(const talus_energy& e) { return stored(e) + dissipated(e) - e.wall_work; }

TEST(Ledger, of_an_impact_books_the_lost_energy_as_damping) {
    const double speed = 0.1;
    const HertzPair pair = HertzPair::on_rigid_wall(kSand, kSandRadius);
    const double energy = 0.5 * pair.mass * speed * speed;
    for (const int32_t damping : {TALUS_DAMPING_CLIPPED, TALUS_DAMPING_ATTRACTIVE})
        for (const double restitution : {0.2, 0.7, 1.0}) {
            const double time_step = pair.duration(speed) / 4000.0;
            talus_settings settings = bare_settings({-1e-3, -1e-3, -1e-3}, {1e-3, 1e-3, 1e-3}, time_step);
            settings.laws.damping = damping;
            settings.energy_ledger = 1;
            Engine engine(settings);
            const int32_t ball = engine.material(kSand.young, kSand.poisson, kSand.density);
            const int32_t floor = engine.rigid_material();
            engine.contact(ball, ball, 1.0, 0.0);
            engine.contact(ball, floor, restitution, 0.0);
            engine.wall(floor, {0.0, 0.0, 0.0}, {0.0, 1.0, 0.0});
            engine.insert({{{0.0, kSandRadius + 1.5 * speed * time_step, 0.0}, kSandRadius, {0.0, -speed, 0.0}}});
            engine.step(20000);
            const talus_energy e = engine.energy();
            // First order in the step, as the restitution is: 2 (1e-4) at most at 4000 steps a contact; none at e = 1.
            const double tolerance = restitution == 1.0 ? 1e-7 : 5e-4;
            EXPECT_NEAR(e.damping / energy, 1.0 - restitution * restitution, tolerance);
            EXPECT_NEAR(e.kinetic / energy, restitution * restitution, tolerance);
            EXPECT_NEAR(balance(e) / energy, 1.0, tolerance);
            EXPECT_EQ(e.friction, 0.0);
            EXPECT_EQ(e.rolling, 0.0);
            EXPECT_EQ(e.wall_work, 0.0) << "a wall at rest does no work";
            EXPECT_EQ(e.elastic_normal, 0.0) << "nothing is in touch";
        }
}

TEST(Ledger, of_a_ball_on_a_moving_floor_splits_the_work_of_the_floor) {
    // A ball laid on a floor that moves at u slides until it rolls at 2u/7: the floor has done u times its momentum, 2/7 m u^2, of
    // which the ball has half, translation and rotation, and half is heat.
    const Solid solid{1.0e7, 0.25, 2500.0};
    const double radius = 5.0e-3;
    const double speed = 0.5;
    const double friction = 0.3;
    const HertzPair pair = HertzPair::on_rigid_wall(solid, radius);
    const double time_step = 4.0e-5;
    talus_settings settings = bare_settings({-0.1, -0.02, -0.05}, {1.0, 0.05, 0.05}, time_step);
    settings.gravity[1] = -9.81;
    settings.energy_ledger = 1;
    Engine engine(settings);
    const int32_t ball = engine.material(solid.young, solid.poisson, solid.density);
    const int32_t belt = engine.rigid_material();
    engine.contact(ball, ball, 0.2, friction);
    engine.contact(ball, belt, 0.2, friction);
    const int32_t wall = engine.wall(belt, {0.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {speed, 0.0, 0.0});
    engine.insert({{{0.0, radius - pair.overlap_under(pair.mass * 9.81), 0.0}, radius}});
    engine.step();
    const double start = balance(engine.energy());
    const double until = 2.0 * speed / (7.0 * friction * 9.81);
    engine.step(static_cast<int64_t>(2.0 * until / time_step));
    const talus_energy e = engine.energy();
    const double unit = pair.mass * speed * speed;
    // Rolling is exact (test_rolling). The work counts the force once a step: half a step of it, until/dt = 1200 steps, and as much
    // for the heat.
    const double half_step = 0.5 * time_step / until;
    EXPECT_NEAR(engine.velocities()[0][0] / speed, 2.0 / 7.0, 1e-8);
    EXPECT_NEAR(e.kinetic / unit, 0.5 * 4.0 / 49.0, 1e-8);
    EXPECT_NEAR(e.rotational / unit, 0.2 * 25.0 / 49.0, 1e-8);
    EXPECT_NEAR(e.wall_work / unit, 2.0 / 7.0, 2.0 / 7.0 * 1.1 * half_step);
    EXPECT_NEAR(engine.wall_state(wall).work, e.wall_work, 1e-12 * unit);
    EXPECT_NEAR((e.friction + e.damping) / unit, 1.0 / 7.0, 2.0 / 7.0 * 1.1 * half_step);
    EXPECT_NEAR((balance(e) - start) / unit, 0.0, 2.0 / 7.0 * 1.1 * half_step);
}

// ---- A box that shears, in every law ---------------------------------------------------------------------------------

struct Closing {
    double error = 0.0; // change of the balance over the energy dissipated
    talus_energy energy{};
};

/// Forty grains fall into a box, then its floor drags them and a side wall pushes.
Closing shear_box(const talus_laws& laws, double step_fraction) {
    BedScene scene;
    scene.grains = 40;
    scene.width_x = scene.width_z = 8.0e-3;
    scene.restitution = 0.5;
    scene.friction = 0.5;
    scene.floor_friction = 0.4;
    scene.side_friction = 0.2;
    scene.rolling_friction = 0.1;
    scene.energy_ledger = 1;
    scene.step_fraction = step_fraction;
    scene.laws = laws;
    Bed bed = pour(scene);
    bed.engine.step();
    const double start = balance(bed.engine.energy());
    bed.engine.step(static_cast<int64_t>(0.03 / scene.time_step()));
    bed.engine.wall_velocity(bed.floor, {0.2, 0.0, 0.0});
    bed.engine.wall_velocity(bed.sides[0], {0.1, 0.0, 0.0});
    bed.engine.step(static_cast<int64_t>(0.02 / scene.time_step()));
    Closing closing;
    closing.energy = bed.engine.energy();
    closing.error = (balance(closing.energy) - start) / dissipated(closing.energy);
    return closing;
}

TEST(Ledger, closes_in_every_law_to_first_order_in_the_step) {
    const double coarse = 0.2;
    const double fine = 0.05;
    double sum_coarse = 0.0;
    double sum_fine = 0.0;
    double largest[2] = {0.0, 0.0};
    for (const int32_t normal : {TALUS_NORMAL_HERTZ, TALUS_NORMAL_LINEAR})
        for (const int32_t damping : {TALUS_DAMPING_CLIPPED, TALUS_DAMPING_ATTRACTIVE})
            for (const int32_t tangential :
                 {TALUS_TANGENTIAL_FORCE_RESCALED, TALUS_TANGENTIAL_FORCE, TALUS_TANGENTIAL_DISPLACEMENT, TALUS_TANGENTIAL_NONE})
                for (const int32_t rolling : {TALUS_ROLLING_NONE, TALUS_ROLLING_CONSTANT, TALUS_ROLLING_SPRING}) {
                    SCOPED_TRACE(testing::Message() << "normal " << normal << " damping " << damping << " tangential " << tangential
                                                    << " rolling " << rolling);
                    talus_laws laws = bare_settings({}, {}, 0.0).laws;
                    laws.normal = normal;
                    laws.damping = damping;
                    laws.tangential = tangential;
                    laws.rolling = rolling;
                    // A ramp that the step resolves under these weights; below it type A trembles (test_rolling).
                    laws.rolling_rate = 2.0;
                    laws.stiffness_n = 2.0e3;
                    const Closing at_coarse = shear_box(laws, coarse);
                    const Closing at_fine = shear_box(laws, fine);
                    const bool has_friction = tangential != TALUS_TANGENTIAL_NONE;
                    EXPECT_EQ(at_fine.energy.friction > 0.0, has_friction);
                    EXPECT_EQ(at_fine.energy.rolling > 0.0, has_friction && rolling != TALUS_ROLLING_NONE); // else nothing spins
                    EXPECT_GT(at_fine.energy.damping, 0.0);
                    EXPECT_GT(at_fine.energy.wall_work, 0.0);
                    // Heat is counted with the velocity of the middle of a step and the force of its end: an error of half a
                    // step of each change of force, first order. Of the energy dissipated, per share of Rayleigh's step: up to
                    // 0.24 (Hertz) and 0.45 (linear law, whose damping force jumps at first touch) in an independent code at four
                    // steps. The bound is those and a third, since every code has its own trajectories.
                    const double share = normal == TALUS_NORMAL_HERTZ ? 0.32 : 0.60;
                    EXPECT_LE(std::fabs(at_coarse.error), share * coarse);
                    EXPECT_LE(std::fabs(at_fine.error), share * fine);
                    sum_coarse += std::fabs(at_coarse.error);
                    sum_fine += std::fabs(at_fine.error);
                    double& worst = largest[normal == TALUS_NORMAL_LINEAR ? 1 : 0];
                    worst = std::max(worst, std::fabs(at_fine.error));
                }
    // 48 scenes of their own trajectories average to a clean order.
    EXPECT_NEAR(observed_order(sum_coarse, sum_fine, coarse / fine), 1.0, 0.2);
    std::printf("  mean error of the ledger: %.2f %% of the dissipated energy at %.2f of Rayleigh's step, %.2f %% at %.2f "
                "(largest %.2f %% Hertz, %.2f %% linear)\n",
                100.0 * sum_coarse / 48.0, coarse, 100.0 * sum_fine / 48.0, fine, 100.0 * largest[0], 100.0 * largest[1]);
}

} // namespace
} // namespace talus::test
