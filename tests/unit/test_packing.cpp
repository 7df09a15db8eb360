// Filling a box: no overlaps, everything inside, and a grain that hangs on its place alone.
#include <gtest/gtest.h>

#include <cmath>

#include "core/packing.hpp"

namespace talus::core {
namespace {

FillPlan plan_of(double jitter, double room, int layer_axis, bool down = false) {
    FillPlan p{};
    const double lo[3] = {-1.0, 2.0, 0.5}, hi[3] = {8.3, 12.9, 7.7};
    for (int a = 0; a < 3; ++a) {
        p.lo[a] = lo[a];
        p.hi[a] = hi[a];
    }
    p.radius_min = 0.3;
    p.radius_max = 0.5;
    p.jitter = jitter;
    p.room = room;
    p.seed = 42;
    p.layer_axis = layer_axis;
    p.layers_down = down;
    plan_lattice(p);
    return p;
}

TEST(Packing, grains_neither_overlap_nor_cross_the_box) {
    for (int axis = 0; axis < 3; ++axis)
        for (const double jitter : {0.0, 0.5, 1.0})
            for (const double room : {0.0, 0.1, 0.7}) {
                const FillPlan plan = plan_of(jitter, room, axis);
                std::vector<FilledGrain> grains;
                for (std::int64_t k = 0; k < plan.n_places(); ++k) grains.push_back(grain_at(plan, k));
                ASSERT_GT(grains.size(), 50u);
                const double rounding = 1e-14;
                for (std::size_t i = 0; i < grains.size(); ++i) {
                    ASSERT_GE(grains[i].radius, 0.3);
                    ASSERT_LE(grains[i].radius, 0.5);
                    for (int a = 0; a < 3; ++a) {
                        ASSERT_GE(grains[i].position[a] - grains[i].radius, plan.lo[a] - rounding);
                        ASSERT_LE(grains[i].position[a] + grains[i].radius, plan.hi[a] + rounding);
                    }
                    for (std::size_t j = 0; j < i; ++j) {
                        double square = 0.0;
                        for (int a = 0; a < 3; ++a) square += std::pow(grains[i].position[a] - grains[j].position[a], 2);
                        ASSERT_GE(std::sqrt(square), grains[i].radius + grains[j].radius - rounding);
                    }
                }
            }
}

TEST(Packing, a_grain_hangs_on_seed_and_place_only) {
    const FillPlan plan = plan_of(1.0, 0.1, 1);
    FillPlan other = plan;
    other.seed = 43;
    int differ = 0;
    for (std::int64_t k = plan.n_places() - 1; k >= 0; --k) { // backwards: nothing is carried from place to place
        const FilledGrain a = grain_at(plan, k), b = grain_at(plan, k), c = grain_at(other, k);
        EXPECT_EQ(a.radius, b.radius);
        differ += a.radius != c.radius ? 1 : 0;
        for (int x = 0; x < 3; ++x) EXPECT_EQ(a.position[x], b.position[x]);
    }
    EXPECT_EQ(differ, plan.n_places());
}

TEST(Packing, places_are_counted_layer_by_layer_from_the_bottom_or_from_the_top) {
    for (int axis = 0; axis < 3; ++axis) {
        const FillPlan up = plan_of(0.0, 0.1, axis), down = plan_of(0.0, 0.1, axis, true);
        for (std::int64_t k = 1; k < up.n_places(); ++k) {
            EXPECT_GE(grain_at(up, k).position[axis], grain_at(up, k - 1).position[axis]);
            EXPECT_LE(grain_at(down, k).position[axis], grain_at(down, k - 1).position[axis]);
        }
        EXPECT_NEAR(grain_at(up, 0).position[axis], up.lo[axis] + 0.55, 1e-12);
    }
}

TEST(Packing, a_box_too_small_for_one_grain_has_no_place) {
    FillPlan p = plan_of(1.0, 0.1, 1);
    p.hi[0] = p.lo[0] + 1.09;
    plan_lattice(p);
    EXPECT_EQ(p.n_places(), 0);
    p.hi[0] = p.lo[0] + 1.11;
    plan_lattice(p);
    EXPECT_GT(p.n_places(), 0);
}

TEST(Packing, radii_are_uniform_between_their_bounds) {
    FillPlan p = plan_of(1.0, 0.1, 1);
    p.hi[1] = 300.0;
    plan_lattice(p);
    double sum = 0.0, square = 0.0;
    const auto n = static_cast<double>(p.n_places());
    for (std::int64_t k = 0; k < p.n_places(); ++k) {
        const double u = (grain_at(p, k).radius - 0.3) / 0.2;
        sum += u;
        square += u * u;
    }
    EXPECT_NEAR(sum / n, 0.5, 5.0 / std::sqrt(12.0 * n));
    EXPECT_NEAR(square / n, 1.0 / 3.0, 5.0 * std::sqrt(4.0 / 45.0 / n));
}

} // namespace
} // namespace talus::core
