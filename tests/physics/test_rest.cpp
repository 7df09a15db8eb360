// Grains at rest, weight and pressure, and what must be conserved: internal forces, momentum, energy of an elastic gas.
// physics.md section 6.

#include "../support/bed.hpp"
#include "../support/engine.hpp"
#include "../support/theory.hpp"

#include <gtest/gtest.h>

#include <cstdio>

namespace talus::test {
namespace {

constexpr double kGravity = 9.81;

// ---- One ball --------------------------------------------------------------------------------------------------------

TEST(RestingBall, sinks_in_by_the_overlap_that_carries_it) {
    // A tilted plane with gravity along its normal, so that nothing is special about an axis.
    const Vec3 normal{2.0 / 7.0, 6.0 / 7.0, 3.0 / 7.0};
    const double radii[] = {1.0e-4, 1.0e-3, 4.0e-3};
    const Solid solid{1.0e7, 0.25, 2500.0};
    for (const int32_t law : {TALUS_NORMAL_HERTZ, TALUS_NORMAL_LINEAR}) {
        for (const double radius : radii) {
            const HertzPair pair = HertzPair::on_rigid_wall(solid, radius);
            const double weight = pair.mass * kGravity;
            const double stiffness = 2.0 * solid.young * radius * 0.05; // a hundredth of a diameter or less at these weights
            const double overlap = law == TALUS_NORMAL_HERTZ ? pair.overlap_under(weight) : weight / stiffness;
            const double time_step = 0.1 * solid.rayleigh_step(radius);
            talus_settings settings =
                bare_settings({-4 * radius, -4 * radius, -4 * radius}, {4 * radius, 4 * radius, 4 * radius}, time_step);
            for (int axis = 0; axis < 3; ++axis) settings.gravity[axis] = -kGravity * normal[axis];
            settings.laws.normal = law;
            settings.laws.stiffness_n = stiffness;
            Engine engine(settings);
            const int32_t ball = engine.material(solid.young, solid.poisson, solid.density);
            const int32_t floor = engine.rigid_material();
            engine.contact(ball, ball, 0.2, 0.5);
            engine.contact(ball, floor, 0.2, 0.5);
            const int32_t wall = engine.wall(floor, {0.0, 0.0, 0.0}, normal);
            engine.insert({{(radius + 0.5 * overlap) * normal, radius}});
            // Small oscillations have w = sqrt(1.5 g/overlap) (Hertz) or sqrt(g/overlap) and decay with some 0.7 w.
            const double slowest = std::sqrt(overlap / kGravity);
            engine.step(static_cast<int64_t>(200.0 * slowest / time_step));
            const double unit = engine.internal_force_sum().second;
            const Vec3 place = engine.positions()[0];
            // The force can only balance to a unit of the sum; the overlap is a difference of lengths near the radius, each of
            // some ten roundings.
            const double tolerance = 2.0 * unit / weight + 10.0 * radius * 1.2e-16 / overlap + 1e-12;
            EXPECT_NEAR((radius - dot(place, normal)) / overlap, 1.0, tolerance) << "R = " << radius << ", law " << law;
            EXPECT_LE(tolerance, 1e-7) << "force unit " << unit << " N against " << weight << " N";
            EXPECT_LE(length(place - dot(place, normal) * normal), 1e-9 * radius) << "no reason to move sideways";
            EXPECT_NEAR(-dot(engine.wall_force(wall), normal) / weight, 1.0, tolerance);
        }
    }
}

// ---- A box of grains -------------------------------------------------------------------------------------------------

struct Sums {
    Vec3 momentum{};
    Vec3 wall_force{}; // of the walls on the grains
    double mass = 0.0;
};

Sums sums(Bed& bed) {
    Sums s;
    const auto masses = bed.engine.masses();
    const auto velocities = bed.engine.velocities();
    for (std::size_t i = 0; i < masses.size(); ++i) {
        s.mass += masses[i];
        s.momentum = s.momentum + masses[i] * velocities[i];
    }
    s.wall_force = s.wall_force - bed.engine.wall_force(bed.floor);
    for (const int32_t side : bed.sides)
        if (side >= 0) s.wall_force = s.wall_force - bed.engine.wall_force(side);
    return s;
}

TEST(BoxOfGrains, floor_and_walls_carry_the_weight) {
    BedScene scene;
    scene.width_x = scene.width_z = 9.0e-3;
    scene.grains = 300;
    scene.friction = 0.5;
    scene.floor_friction = 0.25;
    scene.side_friction = 0.25;
    Bed bed = pour(scene);
    const double time_step = scene.time_step();

    // While they fall and collide: the momentum gained in a step is the mean of the wall forces before and after it, and
    // the weight. Internal forces cancel to the last bit, so only the rounding of 300 velocities is left: 1e-16 of their
    // speed (0.3 m/s) against g dt (1e-4 m/s), 3e-13.
    for (const int64_t steps : {1000, 3000, 3000}) {
        bed.engine.step(steps);
        const Sums before = sums(bed);
        bed.engine.step(1);
        const Sums after = sums(bed);
        const double weight = before.mass * kGravity;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double wall = 0.5 * (before.wall_force[axis] + after.wall_force[axis]);
            const double gained = (after.momentum[axis] - before.momentum[axis]) / time_step;
            EXPECT_NEAR(gained / weight, wall / weight - (axis == 1 ? 1.0 : 0.0), 1e-10) << "axis " << axis;
        }
    }

    // At rest the mean wall force over a window differs from the weight by the momentum change over the window, P/(M g T): with
    // kinetic energy 1e-5 m g d a grain the common velocity is at most sqrt(2e-5 g d) = 6e-4 m/s, against g T = 0.46 m/s.
    settle(bed, scene, 1e-5, 40000);
    Vec3 mean{};
    const int samples = 2000;
    for (int i = 0; i < samples; ++i) {
        bed.engine.step(2);
        mean = mean + (1.0 / samples) * sums(bed).wall_force;
    }
    const double weight = sums(bed).mass * kGravity;
    EXPECT_NEAR(mean[1] / weight, 1.0, 3e-3);
    EXPECT_NEAR(mean[0] / weight, 0.0, 3e-3);
    EXPECT_NEAR(mean[2] / weight, 0.0, 3e-3);
    // The side walls pull up or, where the bed sprang back after its fall, down: not the floor alone is tested.
    EXPECT_GT(std::fabs(-bed.engine.wall_force(bed.floor)[1] / weight - 1.0), 0.02);
}

TEST(BoxOfGrains, with_frictionless_walls_has_the_pressure_of_its_depth) {
    BedScene scene;
    scene.width_x = scene.width_z = 14.0e-3;
    scene.grains = 700;
    scene.friction = 0.3;
    scene.floor_friction = 0.3;
    Bed bed = pour(scene);
    settle(bed, scene, 1e-5, 30000);

    const auto masses = bed.engine.masses();
    const auto places = bed.engine.positions();
    double weight = 0.0;
    double moment = 0.0; // sum of m g y
    for (std::size_t i = 0; i < masses.size(); ++i) {
        weight += masses[i] * kGravity;
        moment += masses[i] * kGravity * places[i][1];
    }
    const auto weight_above = [&](double level) {
        double above = 0.0;
        for (std::size_t i = 0; i < masses.size(); ++i)
            if (places[i][1] > level) above += masses[i] * kGravity;
        return above;
    };
    // The mean of the vertical stress over a horizontal slice, by the cross-section of the box.
    const auto vertical_stress = [&](double from, double to) {
        const double margin = 0.5e-3; // the box must hold every centre; what is outside the walls holds none
        const Stress s = bed.engine.stress({-margin, from, -margin}, {scene.width_x + margin, to, scene.width_z + margin});
        const double widened = (scene.width_x + 2.0 * margin) * (scene.width_z + 2.0 * margin);
        return -s.tensor[4] * widened / scene.area();
    };

    EXPECT_NEAR(-bed.engine.wall_force(bed.floor)[1] / weight, 1.0, 1e-2); // 50 times the rate of change seen at rest

    // Over the whole bed the virial is exact at rest: volume times mean stress = sum of m g y, whatever the packing. The
    // kinetic part at rest is 1e-5 d / (depth/2) = 1e-6, the rest is the momentum still changing.
    const double roof = bed.top;
    EXPECT_NEAR(vertical_stress(-1.0e-3, roof) * scene.area() * (roof + 1.0e-3) / moment, 1.0, 5e-3);

    // In a slice the stress of physics.md, rho_b g z, is the weight above over the area, averaged over the slice. The contacts
    // that the slice's faces cut count in whole with the grain inside: each shifts its force by up to a radius, on average by
    // nothing, with a spread of 0.25 d a contact; about 40 contacts a face of which the strong half carries the force give
    // 0.05 d a face, 0.08 d for two, so 1.1 % of a slice of 7 d. Three times that.
    const double depth = 2.0 * moment / weight; // of a uniform bed
    const double slice = 0.5 * depth;
    ASSERT_GT(slice, 12.0e-3);
    for (int k = 0; k < 2; ++k) {
        const double from = slice * k;
        double expected = 0.0;
        const int levels = 400;
        for (int i = 0; i < levels; ++i) expected += weight_above(from + slice * (i + 0.5) / levels) / (levels * scene.area());
        const double stress = vertical_stress(from, from + slice);
        std::printf("  from %.1f to %.1f mm: %.1f Pa, weight above %.1f Pa\n", 1e3 * from, 1e3 * (from + slice), stress, expected);
        EXPECT_NEAR(stress / expected, 1.0, 0.035) << "slice " << k;
        // and rho_b g z itself, with the bulk density of the bed and z to the middle of the slice: the bed is not uniform
        // at the floor and at the surface, by about a grain's radius of depth each.
        const double bulk = weight / (scene.area() * depth); // rho_b g
        EXPECT_NEAR(stress / (bulk * (depth - from - 0.5 * slice)), 1.0, 0.10) << "slice " << k;
    }
}

// ---- What is conserved -----------------------------------------------------------------------------------------------

struct Gas {
    Engine engine;
    double speed_scale = 0.0; // sum of m |v|
};

/// Six by six by six grains in a periodic cube, on a jittered lattice, with random velocities and spins.
Gas gas(talus_settings settings, double pitch, double jitter, double restitution, double friction, double speed) {
    const Solid solid{1.0e7, 0.2, 2600.0};
    const int n = 6;
    for (int axis = 0; axis < 3; ++axis) {
        settings.domain_lo[axis] = 0.0;
        settings.domain_hi[axis] = n * pitch;
        settings.periodic[axis] = 1;
    }
    Gas g{Engine(settings)};
    const int32_t a = g.engine.material(solid.young, solid.poisson, solid.density);
    const int32_t b = g.engine.material(2.0 * solid.young, 0.3, solid.density);
    g.engine.contact(a, a, restitution, friction, 0.1);
    g.engine.contact(a, b, restitution, friction, 0.1);
    g.engine.contact(b, b, restitution, friction, 0.1);
    Random random(7);
    std::vector<Grain> grains;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
            for (int k = 0; k < n; ++k) {
                Grain grain;
                grain.radius = random.uniform(0.8e-3, 1.2e-3);
                grain.position = Vec3{(i + 0.5) * pitch, (j + 0.5) * pitch, (k + 0.5) * pitch} + random.vector(jitter);
                grain.velocity = random.vector(speed);
                grain.spin = random.vector(speed / 1.0e-3);
                grain.material = (i + j + k) % 2;
                g.speed_scale += solid.mass(grain.radius) * length(grain.velocity);
                grains.push_back(grain);
            }
    g.engine.insert(grains, 0.5);
    g.engine.step();
    return g;
}

Vec3 momentum(Engine& engine) {
    Vec3 p{};
    const auto masses = engine.masses();
    const auto velocities = engine.velocities();
    for (std::size_t i = 0; i < masses.size(); ++i) p = p + masses[i] * velocities[i];
    return p;
}

TEST(InternalForces, sum_to_exactly_zero_in_every_law) {
    const double time_step = 0.1 * Solid{2.0e7, 0.3, 2600.0}.rayleigh_step(0.8e-3);
    for (const int32_t normal : {TALUS_NORMAL_HERTZ, TALUS_NORMAL_LINEAR})
        for (const int32_t damping : {TALUS_DAMPING_CLIPPED, TALUS_DAMPING_ATTRACTIVE})
            for (const int32_t tangential :
                 {TALUS_TANGENTIAL_FORCE_RESCALED, TALUS_TANGENTIAL_FORCE, TALUS_TANGENTIAL_DISPLACEMENT, TALUS_TANGENTIAL_NONE})
                for (const int32_t rolling : {TALUS_ROLLING_NONE, TALUS_ROLLING_CONSTANT, TALUS_ROLLING_SPRING}) {
                    SCOPED_TRACE(testing::Message() << "normal " << normal << " damping " << damping << " tangential " << tangential
                                                    << " rolling " << rolling);
                    talus_settings settings = bare_settings({}, {}, time_step);
                    settings.laws.normal = normal;
                    settings.laws.damping = damping;
                    settings.laws.tangential = tangential;
                    settings.laws.rolling = rolling;
                    settings.laws.stiffness_n = 2.0e3;
                    // Pitch below the diameter of two mean grains: nearly all touch from the start.
                    Gas g = gas(settings, 1.95e-3, 0.05e-3, 0.5, 0.4, 0.2);
                    const Vec3 before = momentum(g.engine);
                    for (int k = 0; k < 5; ++k) {
                        ASSERT_GT(g.engine.state().contacts, 100);
                        const auto [sum, unit] = g.engine.internal_force_sum();
                        EXPECT_EQ(sum, (std::array<int64_t, 3>{0, 0, 0}));
                        EXPECT_GT(unit, 0.0);
                        g.engine.step(30);
                    }
                    // Momentum then changes by the rounding of velocities alone: 1e-16 a grain and step, at random.
                    EXPECT_LE(length(momentum(g.engine) - before), 1e-13 * g.speed_scale);
                }
}

TEST(ElasticGas, keeps_its_energy_and_momentum) {
    const Solid solid{1.0e7, 0.2, 2600.0};
    for (const int32_t normal : {TALUS_NORMAL_HERTZ, TALUS_NORMAL_LINEAR}) {
        for (const double fraction : {0.15, 0.075}) {
            talus_settings settings = bare_settings({}, {}, fraction * solid.rayleigh_step(0.8e-3));
            settings.laws.tangential = TALUS_TANGENTIAL_NONE;
            settings.laws.normal = normal;
            settings.laws.stiffness_n = 500.0;
            Gas g = gas(settings, 2.67e-3, 0.1e-3, 1.0, 0.0, 0.3);
            const auto total = [&g] {
                const talus_energy e = g.engine.energy();
                return e.kinetic + e.elastic_normal;
            };
            const double energy = total();
            const double turning = g.engine.energy().rotational;
            const Vec3 start = momentum(g.engine);
            const int64_t chunk = static_cast<int64_t>(0.005 / settings.time_step);
            double worst = 0.0;
            for (int k = 0; k < 20; ++k) { // 0.1 s: 35 collisions a grain
                g.engine.step(chunk);
                worst = std::max(worst, std::fabs(total() / energy - 1.0));
            }
            std::printf("  normal law %d, %.3f of Rayleigh's step: energy within %.1e\n", normal, fraction, worst);
            // At 0.15 a contact of the smaller grains lasts 20 steps and returns its energy to 4e-4 (Hertz) or 1e-3 (linear) at
            // worst, with either sign by its phase (test_impact: orders 2.5 and 3). 35 of them a grain, 216 grains: sqrt(35/108)
            // of that stays of the total; three times that is the bound, and it must fall with the square of the step.
            const double steps_share = fraction / 0.15;
            EXPECT_LE(worst, (normal == TALUS_NORMAL_LINEAR ? 1.7e-3 : 7e-4) * steps_share * steps_share);
            EXPECT_LE(length(momentum(g.engine) - start), 1e-13 * g.speed_scale);
            EXPECT_EQ(g.engine.energy().rotational, turning) << "nothing turns a frictionless grain";
        }
    }
}

} // namespace
} // namespace talus::test
