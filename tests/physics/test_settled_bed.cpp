// timeout: 300
// A bed settled without friction is random close packed: solid fraction and contacts of physics.md section 6. The short
// version: 2000 grains, periodic in x and z, 16 grains deep, so that half of the depth is bulk. The paper's own sand is in
// test_settled_bed_slow.cpp.

#include "../support/bed.hpp"
#include "../support/packing.hpp"

#include <gtest/gtest.h>

#include <cstdio>

namespace talus::test {
namespace {

TEST(SettledBed, without_friction_is_random_close_packed) {
    BedScene scene;
    scene.periodic = true;
    scene.width_x = scene.width_z = 20.0e-3;
    scene.grains = 2000;
    // (E*/P)^(2/3) = 740 at the base: as soft under its depth as the paper's bed, 675. Softer beds have more contacts.
    scene.solid.young = 2.0e7;
    Bed bed = pour(scene);
    ASSERT_EQ(bed.count, scene.grains);

    // At rest by criterion: kinetic energy below 3e-4 m g d a grain, after the fall.
    const int64_t taken = settle(bed, scene, 3e-4, 80000);
    const talus_state state = bed.engine.state();
    ASSERT_LT(taken, 80000) << "not at rest";

    const double diameter = scene.radius_min + scene.radius_max;
    const auto radii = bed.engine.radii();
    const Packing packing(bed.engine.positions(), radii, scene.width_x, scene.width_z);
    const double from = 4.0 * diameter;
    const double to = packing.surface() - 4.0 * diameter;
    ASSERT_GT(to - from, 7.0 * diameter);

    // The figures of physics.md, which has them from beds of another code. A bed of this size scatters by 0.002 in solid fraction
    // from seed to seed; contacts are a mean over ten moments, since grains still tremble at this criterion.
    const int moments = 10;
    double contacts = 0.0;
    double solid = 0.0;
    double rattlers = 0.0;
    for (int k = 0; k < moments; ++k) {
        bed.engine.step(500);
        const Packing now(bed.engine.positions(), radii, scene.width_x, scene.width_z);
        const Packing::Slice bulk = now.slice(from, to);
        contacts += bulk.contacts_of_frame / moments;
        solid += bulk.solid_fraction / moments;
        rattlers += static_cast<double>(bulk.rattlers) / static_cast<double>(bulk.grains) / moments;
        // The engine counts the same contacts: centres in the box, touching or not decided by the same comparison.
        const Stress stress = bed.engine.stress({0.0, from, 0.0}, {scene.width_x, to, scene.width_z});
        EXPECT_NEAR(stress.coordination, bulk.contacts, 1e-3) << "a contact at the last bit may differ, two do not";
        // By centres instead of exactly: faces that cut grains scatter by a few grains of a thousand.
        EXPECT_NEAR(stress.solid_fraction, bulk.solid_fraction, 0.015);
    }
    std::printf("  %lld steps, %.1f d deep, unbalanced %.3f: solid fraction %.4f, %.3f contacts, %.1f %% rattlers\n",
                static_cast<long long>(taken), packing.surface() / diameter, state.unbalanced_force, solid, contacts, 100.0 * rattlers);
    EXPECT_GE(solid, 0.630);
    EXPECT_LE(solid, 0.645);
    EXPECT_GE(contacts, 6.0);
    EXPECT_LE(contacts, 6.3);
}

} // namespace
} // namespace talus::test
