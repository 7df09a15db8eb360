// label: slow
// timeout: 1800
// Long beds: the paper's sand settled without friction at half of the paper's depth, and Janssen's column.
// physics.md sections 1 and 6.

#include "../support/bed.hpp"
#include "../support/packing.hpp"

#include <gtest/gtest.h>

#include <cstdio>

namespace talus::test {
namespace {

constexpr double kGravity = 9.81;

TEST(SettledBed, of_the_papers_sand_is_random_close_packed) {
    BedScene scene;
    scene.periodic = true;
    scene.solid = kSand;
    scene.radius_min = 0.5 * 205.0e-6;
    scene.radius_max = 0.5 * 250.0e-6;
    scene.width_x = scene.width_z = 3.0e-3; // 13 grains
    scene.grains = 8000;                    // 40 grains deep
    scene.step_fraction = 0.2;
    Bed bed = pour(scene);
    const int64_t taken = settle(bed, scene, 2e-4, 400000);
    ASSERT_LT(taken, 400000) << "not at rest";

    const double diameter = scene.radius_min + scene.radius_max;
    const auto radii = bed.engine.radii();
    const Packing packing(bed.engine.positions(), radii, scene.width_x, scene.width_z);
    const double from = 4.0 * diameter;
    const double to = packing.surface() - 4.0 * diameter;
    ASSERT_GT(to - from, 25.0 * diameter);
    const int moments = 10;
    double contacts = 0.0;
    double solid = 0.0;
    for (int k = 0; k < moments; ++k) {
        bed.engine.step(500);
        const Packing now(bed.engine.positions(), radii, scene.width_x, scene.width_z);
        const Packing::Slice bulk = now.slice(from, to);
        contacts += bulk.contacts_of_frame / moments;
        solid += bulk.solid_fraction / moments;
    }
    std::printf("  %lld steps, %.1f d deep: solid fraction %.4f, %.3f contacts\n", static_cast<long long>(taken),
                packing.surface() / diameter, solid, contacts);
    EXPECT_GE(solid, 0.630);
    EXPECT_LE(solid, 0.645);
    EXPECT_GE(contacts, 6.0);
    EXPECT_LE(contacts, 6.3);
}

struct Column {
    const char* name;
    double width; // in mean diameters
    int64_t grains;
    double wall_friction;
};

class JanssenColumn : public testing::TestWithParam<Column> {};

TEST_P(JanssenColumn, carries_its_weight_as_janssen_says) {
    const Column& column = GetParam();
    BedScene scene;
    scene.width_x = scene.width_z = column.width * 2.0e-3;
    scene.grains = column.grains;
    scene.friction = 0.5;
    scene.floor_friction = 0.5;
    scene.side_friction = column.wall_friction;
    scene.rolling_friction = 0.1; // else grains roll along the walls and friction there stays below its limit
    scene.laws.rolling = TALUS_ROLLING_SPRING;
    scene.step_fraction = 0.2;
    Bed bed = pour(scene);
    settle(bed, scene, 1e-4, 60000);

    // The walls creep upwards until friction is mobilised everywhere, then over half a grain the means are taken.
    const double speed = 20.0e-3;
    for (const int32_t side : bed.sides) bed.engine.wall_velocity(side, {0.0, speed, 0.0});
    const auto steps_of = [&](double way) { return static_cast<int64_t>(way / speed / scene.time_step()); };
    bed.engine.step(steps_of(1.0e-3));

    const auto masses = bed.engine.masses();
    double weight = 0.0;
    for (const double mass : masses) weight += mass * kGravity;
    const double margin = 0.5e-3; // the box must hold every centre
    const double widened = (scene.width_x + 2.0 * margin) * (scene.width_z + 2.0 * margin);
    const int slices = 6;
    const int samples = 60;
    double depth = 0.0, normal = 0.0, friction = 0.0, floor = 0.0, integral = 0.0;
    double stress[slices] = {};
    for (int k = 0; k < samples; ++k) {
        bed.engine.step(steps_of(1.0e-3) / samples);
        double moment = 0.0;
        const auto places = bed.engine.positions();
        for (std::size_t i = 0; i < masses.size(); ++i) moment += masses[i] * kGravity * places[i][1];
        const double now = 2.0 * moment / weight;
        depth += now / samples;
        for (int s = 0; s < 4; ++s) {
            const Vec3 force = bed.engine.wall_force(bed.sides[s]);
            normal += std::fabs(s < 2 ? force[0] : force[2]) / samples;
            friction -= force[1] / samples;
        }
        floor -= bed.engine.wall_force(bed.floor)[1] / samples;
        const auto mean_stress = [&](double from, double to) {
            const Stress s = bed.engine.stress({-margin, from, -margin}, {scene.width_x + margin, to, scene.width_z + margin});
            return -s.tensor[4] * widened / scene.area();
        };
        integral += mean_stress(-1.0e-3, bed.top) * (bed.top + 1.0e-3) / samples;
        for (int s = 0; s < slices; ++s) stress[s] += mean_stress(now * s / slices, now * (s + 1) / slices) / samples;
    }

    // All friction of the walls works upwards at its limit.
    EXPECT_NEAR(friction / (column.wall_friction * normal), 1.0, 0.02);
    EXPECT_NEAR((floor + friction) / weight, 1.0, 0.01);

    // K is the bed's own: mean pressure on the walls over mean vertical stress. With it Janssen has nothing left to fit.
    const double ratio = normal / (4.0 * scene.width_x * integral);
    const double length = scene.width_x / (4.0 * ratio * column.wall_friction);
    const double unit = weight / (scene.area() * depth); // rho_b g
    EXPECT_GT(ratio, 0.5);
    EXPECT_LT(ratio, 1.0);
    const double expected_floor = unit * length * (1.0 - std::exp(-depth / length)) * scene.area();
    std::printf("  K %.3f, length %.2f widths, %.2f widths deep: floor carries %.3f of the weight, Janssen %.3f;", ratio,
                length / scene.width_x, depth / scene.width_x, floor / weight, expected_floor / weight);
    // Janssen takes K and the stress as the same over a cross-section; at the floor friction breaks that for a grain or two.
    EXPECT_NEAR(floor / expected_floor, 1.0, 0.05);
    for (int s = 0; s < slices; ++s) {
        const double top = depth - depth * (s + 1) / slices;
        const double bottom = depth - depth * s / slices;
        const double expected = unit * length * (1.0 - length / (bottom - top) * (std::exp(-top / length) - std::exp(-bottom / length)));
        std::printf(" %.3f", stress[s] / expected);
        // As in test_rest: a slice counts whole grains at its faces, 0.05 d a face for 40 contacts and so 2 % of 4 d; K varies
        // along a column of a few hundred contacts by some percent more. The top slice holds the uneven surface.
        EXPECT_NEAR(stress[s] / expected, 1.0, s + 1 < slices ? 0.10 : 0.20) << "slice " << s;
    }
    std::printf("\n");
}

INSTANTIATE_TEST_SUITE_P(Columns, JanssenColumn, testing::Values(Column{"narrow", 6.0, 900, 0.15}, Column{"wide", 8.0, 2200, 0.15}),
                         [](const auto& info) { return std::string(info.param.name); });

} // namespace
} // namespace talus::test
