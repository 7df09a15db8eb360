// Velocity Verlet of a tile: projectiles, wraps, groups, and the bookkeeping around it.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "../support/bed.hpp"
#include "core/integrate.hpp"

namespace talus::core {
namespace {

struct Bench {
    IntegrateContext c;
    std::vector<Particle> particles;
    std::vector<Reference> references;
    Tile tile;

    explicit Bench(int n, std::uint64_t seed = 1) {
        test::Random random(seed);
        for (int a = 0; a < 3; ++a) c.domain.hi[a] = 10.0;
        c.dt = 1.0 / 64.0;
        c.units = FixedUnits::make(16.0, 0.5, 10.0);
        for (int k = 0; k < n; ++k) {
            Particle p{};
            for (int a = 0; a < 3; ++a) {
                p.position[a] = p.listed_position[a] = random.uniform(3.0, 7.0);
                p.velocity[a] = random.uniform(-1.0, 1.0);
                p.angular_velocity[a] = random.uniform(-9.0, 9.0);
            }
            p.radius = random.uniform(0.2, 0.5);
            p.mass = random.uniform(0.5, 2.0);
            p.meta = make_meta(3, k % 4, 0xff);
            p.label = k;
            particles.push_back(p);
            references.push_back({p.position[0], p.position[1], p.position[2]});
            ForceSum f{};
            for (int a = 0; a < 3; ++a) {
                f.force[a] = static_cast<std::int64_t>(random.uniform(-1e14, 1e14));
                f.torque[a] = static_cast<std::int64_t>(random.uniform(-1e14, 1e14));
            }
            tile.sums.push_back(f);
        }
        tile.count = static_cast<std::uint32_t>(n);
    }
    void run(bool finish, bool begin) {
        c.finish = finish;
        c.begin = begin;
        integrate_tile(c, particles.data(), references.data(), tile);
    }
};

TEST(Integrate, a_projectile_follows_its_parabola_exactly) {
    Bench b(1);
    b.tile.sums[0] = ForceSum{};
    b.c.gravity[1] = -8.0; // powers of two: every product is exact
    const Particle start = b.particles[0];
    b.run(false, true);
    for (int k = 1; k < 64; ++k) b.run(true, true);
    b.run(true, false);
    EXPECT_NEAR(b.particles[0].position[0], start.position[0] + start.velocity[0], 1e-14);
    EXPECT_NEAR(b.particles[0].position[1], start.position[1] + start.velocity[1] - 4.0, 1e-13);
    EXPECT_NEAR(b.particles[0].velocity[1], start.velocity[1] - 8.0, 1e-14);
    EXPECT_EQ(b.particles[0].velocity[0], start.velocity[0]);
    EXPECT_EQ(std::memcmp(b.particles[0].angular_velocity, start.angular_velocity, 24), 0);
}

TEST(Integrate, forces_and_torques_kick_by_half_a_step_over_mass_and_inertia) {
    Bench b(1);
    const Particle start = b.particles[0];
    const ForceSum f = b.tile.sums[0];
    b.run(true, false);
    const Particle& p = b.particles[0];
    for (int a = 0; a < 3; ++a) {
        const double force = static_cast<double>(f.force[a]) * b.c.units.force.unit, torque = static_cast<double>(f.torque[a]) * b.c.units.torque.unit;
        EXPECT_NEAR(p.velocity[a] - start.velocity[a], 0.5 * b.c.dt * force / p.mass, 1e-14);
        EXPECT_NEAR(p.angular_velocity[a] - start.angular_velocity[a], 0.5 * b.c.dt * torque / (0.4 * p.mass * p.radius * p.radius), 1e-13);
        EXPECT_EQ(p.position[a], start.position[a]) << "finishing moves nothing";
        EXPECT_EQ(b.tile.sums[0].force[a], f.force[a]) << "and keeps the sums";
    }
}

TEST(Integrate, beginning_a_step_leaves_sums_radius_mass_material_and_label_alone) {
    Bench b(7);
    const auto before = b.particles;
    const auto sums = b.tile.sums;
    b.run(false, true);
    for (std::size_t k = 0; k < 7; ++k) {
        EXPECT_EQ(b.particles[k].radius, before[k].radius);
        EXPECT_EQ(b.particles[k].mass, before[k].mass);
        EXPECT_EQ(b.particles[k].meta, before[k].meta);
        EXPECT_EQ(b.particles[k].label, before[k].label);
        for (int a = 0; a < 3; ++a) {
            EXPECT_EQ(b.tile.sums[k].force[a], sums[k].force[a]);
            EXPECT_EQ(b.tile.sums[k].torque[a], sums[k].torque[a]);
        }
    }
}

TEST(Integrate, finish_and_begin_in_one_pass_have_the_bits_of_two_passes) {
    Bench one(50), two(50);
    one.c.gravity[2] = two.c.gravity[2] = -3.3;
    one.run(true, true);
    two.run(true, false);
    two.run(false, true);
    EXPECT_EQ(std::memcmp(one.particles.data(), two.particles.data(), sizeof(Particle) * 50), 0);
}

TEST(Integrate, a_grain_that_crosses_a_periodic_face_is_wrapped_together_with_its_reference) {
    Bench b(2);
    b.c.domain.periodic[0] = b.c.domain.periodic[1] = true;
    b.tile.sums.assign(2, ForceSum{});
    for (int k = 0; k < 2; ++k) b.particles[k].meta = make_meta(0, 0, 0);
    b.particles[0].position[0] = b.particles[0].listed_position[0] = 9.995;
    b.particles[0].velocity[0] = 1.0;
    b.references[0][0] = 9.0;
    b.particles[1].position[1] = b.particles[1].listed_position[1] = 0.005;
    b.particles[1].velocity[1] = -1.0;
    b.references[1][1] = 0.5;
    b.run(false, true);
    EXPECT_NEAR(b.particles[0].position[0], 9.995 + 1.0 / 64 - 10.0, 1e-14);
    EXPECT_NEAR(b.particles[0].position[0] - b.references[0][0], 0.995 + 1.0 / 64, 1e-14) << "the displacement goes on";
    EXPECT_NEAR(b.particles[1].position[1], 0.005 - 1.0 / 64 + 10.0, 1e-14);
    EXPECT_NEAR(b.particles[1].position[1] - b.references[1][1], -0.495 - 1.0 / 64, 1e-14);
    EXPECT_LT(b.tile.displacement.relative_squared(), 1.0) << "a wrap is no displacement";
}

TEST(Integrate, grains_that_slide_together_over_periods_do_not_move_relative_to_each_other) {
    Bench b(2);
    b.c.domain.periodic[0] = true;
    b.tile.sums.assign(2, ForceSum{});
    for (int k = 0; k < 2; ++k) {
        b.particles[k].meta = make_meta(0, 0, 0);
        b.particles[k].velocity[0] = 1.0;
        b.particles[k].velocity[1] = b.particles[k].velocity[2] = 0.0;
    }
    // Two and a half periods: at half of one the two must not be taken for a period apart.
    for (int step = 0; step < 64 * 25; ++step) {
        b.run(step > 0, true);
        ASSERT_LT(b.tile.displacement.relative_squared(), 1e-20) << "step " << step;
    }
}

TEST(Integrate, a_grain_exactly_on_the_upper_face_is_wrapped_to_the_lower_one_and_one_on_the_lower_stays) {
    Domain d;
    d.hi[0] = 10.0;
    d.periodic[0] = true;
    double at[3] = {10.0, 0.0, 0.0};
    Reference r{9.0, 0.0, 0.0};
    wrap(d, at, r);
    EXPECT_EQ(at[0], 0.0);
    EXPECT_EQ(r[0], -1.0);
    wrap(d, at, r);
    EXPECT_EQ(at[0], 0.0);
}

TEST(Integrate, frozen_grains_stand_and_driven_ones_move_as_told_whatever_pushes) {
    Bench b(8);
    b.c.groups[1].mode = GroupMotion::Mode::frozen;
    b.c.groups[2].mode = GroupMotion::Mode::driven;
    for (int a = 0; a < 3; ++a) {
        b.c.groups[2].velocity[a] = 0.25 * (a + 1);
        b.c.groups[2].angular_velocity[a] = -1.0 * a;
    }
    const auto before = b.particles;
    b.run(true, true);
    for (std::size_t k = 0; k < 8; ++k) {
        const int group = group_of(before[k]);
        for (int a = 0; a < 3; ++a) {
            if (group == 1) {
                EXPECT_EQ(b.particles[k].position[a], before[k].position[a]);
                EXPECT_EQ(b.particles[k].velocity[a], 0.0);
                EXPECT_EQ(b.particles[k].angular_velocity[a], 0.0);
            } else if (group == 2) {
                EXPECT_EQ(b.particles[k].position[a], std::fma(0.25 * (a + 1), b.c.dt, before[k].position[a]));
                EXPECT_EQ(b.particles[k].velocity[a], 0.25 * (a + 1));
                EXPECT_EQ(b.particles[k].angular_velocity[a], -1.0 * a);
            } else {
                EXPECT_NE(b.particles[k].position[a], before[k].position[a]);
            }
        }
    }
}

TEST(Integrate, a_grain_ends_with_the_same_bits_wherever_it_stands_in_the_tile) {
    Bench one(40), other(40);
    std::reverse(other.particles.begin(), other.particles.end());
    std::reverse(other.references.begin(), other.references.end());
    std::reverse(other.tile.sums.begin(), other.tile.sums.end());
    one.run(true, true);
    other.run(true, true);
    for (std::size_t k = 0; k < 40; ++k) EXPECT_EQ(std::memcmp(&one.particles[k], &other.particles[39 - k], sizeof(Particle)), 0);
    EXPECT_EQ(one.tile.displacement.relative_squared(), other.tile.displacement.relative_squared());
}

TEST(Integrate, the_displacement_box_holds_every_grain_now_and_three_steps_ahead) {
    Bench b(30);
    for (Particle& p : b.particles)
        for (int a = 0; a < 3; ++a) p.listed_position[a] -= 0.01 * static_cast<double>(p.label % 5);
    b.run(false, true);
    for (int a = 0; a < 3; ++a) {
        double lo = HUGE_VAL, hi = -HUGE_VAL, far = -HUGE_VAL;
        for (const Particle& p : b.particles) {
            const double moved = p.position[a] - p.listed_position[a];
            lo = std::min(lo, moved);
            hi = std::max(hi, moved);
            far = std::max(far, moved + kForeseenSteps * b.c.dt * p.velocity[a]);
        }
        EXPECT_EQ(b.tile.displacement.lo[a], lo);
        EXPECT_EQ(b.tile.displacement.hi[a], hi);
        EXPECT_NEAR(b.tile.displacement.foreseen_hi[a], far, 1e-15);
    }
}

TEST(Integrate, a_velocity_or_spin_that_is_not_finite_is_noted) {
    for (int what = 0; what < 3; ++what) {
        Bench b(5);
        b.run(false, true);
        EXPECT_TRUE(b.tile.finite);
        (what == 0 ? b.particles[3].velocity[1] : what == 1 ? b.particles[3].angular_velocity[2] : b.particles[3].position[0]) = what == 1 ? HUGE_VAL : NAN;
        b.run(true, true);
        EXPECT_FALSE(b.tile.finite) << what;
    }
}

TEST(Integrate, border_rows_are_added_to_their_grains) {
    std::vector<Tile> tiles(2);
    tiles[0].first = 0;
    tiles[0].count = 3;
    tiles[0].sums.assign(3, ForceSum{});
    tiles[0].sums[1].force[0] = 5;
    tiles[0].incoming.push_back({1, 2, 2});
    tiles[1].first = 3;
    tiles[1].count = 2;
    tiles[1].index_of = {3, 4, 1, 2}; // two own grains, then grains 1 and 2 of the first tile
    tiles[1].sums.assign(4, ForceSum{});
    tiles[1].sums[0].force[0] = 1000;
    tiles[1].sums[2].force[0] = 7;
    tiles[1].sums[2].torque[2] = -4;
    tiles[1].sums[3].force[1] = 11;
    collect_border(tiles, tiles[0]);
    EXPECT_EQ(tiles[0].sums[0].force[0], 0);
    EXPECT_EQ(tiles[0].sums[1].force[0], 12);
    EXPECT_EQ(tiles[0].sums[1].torque[2], -4);
    EXPECT_EQ(tiles[0].sums[2].force[1], 11);
    EXPECT_EQ(tiles[1].sums[0].force[0], 1000);
    EXPECT_EQ(tiles[1].sums[2].force[0], 7);
}

} // namespace
} // namespace talus::core
