// The contact laws alone: what must hold of each policy whatever the motion.
#include <gtest/gtest.h>

#include <cmath>

#include "../support/theory.hpp"
#include "../support/bed.hpp"
#include "core/law/contact.hpp"
#include "core/material.hpp"

namespace talus::core {
namespace {

using test::Random;

constexpr Material kSand{1.0e7, 0.2, 2600.0, false};

Vec3d unit_vector(Random& r) {
    for (;;) {
        const Vec3d v{r.uniform(-1, 1), r.uniform(-1, 1), r.uniform(-1, 1)};
        const double n = std::sqrt(dot(v, v));
        if (n > 0.1 && n < 1.0) return v * (1.0 / n);
    }
}
Vec3d turned(const Vec3d& v, const Vec3d& axis, double angle) {
    return v * std::cos(angle) + cross(axis, v) * std::sin(angle) + axis * (dot(axis, v) * (1.0 - std::cos(angle)));
}
double length(const Vec3d& v) { return std::sqrt(dot(v, v)); }

ContactGeometry<double> at_rest(const Vec3d& normal) {
    ContactGeometry<double> g{};
    g.normal = normal;
    g.overlap = 1.0e-5;
    g.radius_eff = g.rolling_radius_i = g.rolling_radius_j = 0.5e-3;
    g.mass_eff = 5.0e-6;
    g.rolling_inertia = 1.0e-12;
    return g;
}
ContactParameters<double> parameters(const Laws& laws, double e, double friction, double rolling) {
    const PairParameters p = derive_parameters(kSand, kSand, {e, friction, rolling, true}, laws);
    return {p.stiffness_n, p.stiffness_t, p.damping_n, p.damping_t, p.friction, p.rolling_friction, p.rolling_damping};
}

template <class Tangential>
TangentialForce<double> step(const ContactGeometry<double>& g, const NormalForce<double>& n, double friction, TangentialRow<double>& row) {
    return Tangential::hold(g, n, friction, Tangential::carry(g, n, 1e-6, row), row);
}

Moments<double> step(const ContactGeometry<double>& g, const NormalForce<double>& n, const ContactParameters<double>& p, double dt, Vec3d& moment) {
    return SpringRolling::hold(g, n, p, SpringRolling::carry(g, n, p, dt, moment), moment);
}

template <class Tangential>
void expect_length_kept() {
    Random random(1);
    const auto p = parameters(Laws{}, 0.5, 1e9, 0.0);
    for (int k = 0; k < 2000; ++k) {
        auto g = at_rest(unit_vector(random));
        const auto n = HertzNormal::evaluate(g, p, 0.0);
        Vec3d spring = cross(g.normal, unit_vector(random));
        TangentialRow<double> row{spring, n.contact_radius};
        const double before = length(spring);
        // Turns by anything from a millionth to half a turn, twenty in a row, each about another axis.
        for (int turn = 0; turn < 20; ++turn) {
            g.normal = turned(g.normal, unit_vector(random), std::pow(10.0, random.uniform(-6.0, 0.497)));
            g.normal = g.normal * (1.0 / length(g.normal));
            step<Tangential>(g, n, p.friction, row);
            ASSERT_NEAR(dot(row.vector, g.normal), 0.0, 1e-9 * before) << "in the tangent plane";
        }
        ASSERT_NEAR(length(row.vector), before, 20 * 4e-16 * before);
    }
}

TEST(Laws, a_rigid_turn_of_the_pair_by_any_angle_about_any_axis_keeps_the_length_of_the_history) {
    expect_length_kept<ForceHistory<true>>();
    expect_length_kept<ForceHistory<false>>();
    expect_length_kept<DisplacementHistory>();
}

TEST(Laws, a_rigid_turn_keeps_the_length_of_the_rolling_spring) {
    Random random(2);
    auto p = parameters(Laws{}, 0.5, 0.5, 1e6); // far from the cap
    for (int k = 0; k < 2000; ++k) {
        auto g = at_rest(unit_vector(random));
        const auto n = HertzNormal::evaluate(g, p, 0.0);
        Vec3d moment = cross(g.normal, unit_vector(random)) * 1e-6;
        const double before = length(moment);
        g.normal = turned(g.normal, unit_vector(random), random.uniform(0.0, 3.14));
        g.normal = g.normal * (1.0 / length(g.normal));
        step(g, n, p, 1e-6, moment);
        ASSERT_NEAR(length(moment), before, 4e-15 * before);
    }
}

TEST(Laws, a_history_that_is_turned_onto_the_normal_itself_ends_without_a_number_going_wrong) {
    auto g = at_rest({0, 1, 0});
    const auto p = parameters(Laws{}, 0.5, 1.0, 0.0);
    const auto n = HertzNormal::evaluate(g, p, 0.0);
    TangentialRow<double> row{{0.0, 1e-3, 0.0}, n.contact_radius};
    const auto f = step<ForceHistory<true>>(g, n, p.friction, row);
    EXPECT_EQ(dot(f.force, f.force), 0.0);
    EXPECT_EQ(dot(row.vector, row.vector), 0.0);
}

TEST(Laws, rescaling_shrinks_the_force_with_the_contact_radius_and_never_lets_it_grow) {
    auto g = at_rest({0, 1, 0});
    const auto p = parameters(Laws{}, 0.5, 1e9, 0.0);
    auto n = HertzNormal::evaluate(g, p, 0.0);
    TangentialRow<double> row{{1e-3, 0.0, 0.0}, n.contact_radius};
    g.overlap *= 0.25;
    n = HertzNormal::evaluate(g, p, 0.0);
    step<ForceHistory<true>>(g, n, p.friction, row);
    EXPECT_NEAR(row.vector.x, 0.5e-3, 1e-18) << "a quarter of the overlap is half of the contact radius";
    g.overlap *= 16.0;
    n = HertzNormal::evaluate(g, p, 0.0);
    step<ForceHistory<true>>(g, n, p.friction, row);
    EXPECT_NEAR(row.vector.x, 0.5e-3, 1e-18);
}

TEST(Laws, the_clipped_damping_ratio_has_the_values_of_physics_md) {
    const double table[][2] = {{0.05, 1.945346}, {0.1, 1.243188}, {0.2, 0.731247}, {0.3, 0.497239}, {0.5, 0.255276}, {0.7, 0.122215}, {0.9, 0.034265}, {0.95, 0.016498}};
    for (const auto& [e, zeta] : table) EXPECT_NEAR(clipped_damping_ratio(e), zeta, 5.1e-7) << e;
    const double attractive[][2] = {{0.2, 0.455950}, {0.5, 0.215454}, {0.9, 0.033518}};
    for (const auto& [e, zeta] : attractive) EXPECT_NEAR(viscous_damping_ratio(e), zeta, 5.1e-7) << e;
    EXPECT_EQ(clipped_damping_ratio(1.0), 0.0);
    EXPECT_EQ(viscous_damping_ratio(1.0), 0.0);
}

TEST(Laws, the_clipped_restitution_is_inverted_falls_steadily_and_is_smooth_at_critical_damping) {
    double before = 1.0;
    for (double zeta = 0.01; zeta < 3.0; zeta += 0.01) {
        const double e = clipped_restitution(zeta);
        EXPECT_LT(e, before);
        before = e;
        EXPECT_NEAR(clipped_damping_ratio(e), zeta, 1e-6 * zeta); // near critical damping the closed form itself loses digits
    }
    EXPECT_NEAR(clipped_restitution(1.0), std::exp(-2.0), 1e-15);
    EXPECT_NEAR(clipped_restitution(1.0 - 1e-6), std::exp(-2.0), 1e-5);
    EXPECT_NEAR(clipped_restitution(1.0 + 1e-6), std::exp(-2.0), 1e-5);
}

TEST(Laws, hertz_damping_is_tsujis_with_alpha_the_square_root_of_five_times_the_damping_ratio) {
    for (const double e : {0.1, 0.5, 0.9}) {
        Laws laws;
        laws.damping = Damping::attractive;
        const auto p = parameters(laws, e, 0.5, 0.0);
        const auto g = at_rest({0, 1, 0});
        const double young = effective_young(kSand, kSand), beta = -std::log(e) / std::hypot(test::kPi, std::log(e));
        const double a = std::sqrt(g.radius_eff * g.overlap), mindlin = 2.0 * std::sqrt(5.0 / 6.0) * beta * std::sqrt(2.0 * young * a * g.mass_eff);
        const double K = 4.0 / 3.0 * young * std::sqrt(g.radius_eff), tsuji = std::sqrt(5.0) * beta * std::sqrt(g.mass_eff * K) * std::pow(g.overlap, 0.25);
        EXPECT_NEAR(tsuji, mindlin, 1e-13 * mindlin);
        auto moving = g;
        moving.parting_speed = 1.0e-3;
        const double infinity = HUGE_VAL;
        const double damping = (HertzNormal::evaluate(g, p, -infinity).total - HertzNormal::evaluate(moving, p, -infinity).total) / 1.0e-3;
        EXPECT_NEAR(damping, tsuji, 1e-10 * tsuji);
    }
}

TEST(Laws, clipped_damping_never_attracts_and_attractive_damping_does) {
    Random random(3);
    int attracted = 0;
    for (const NormalLaw normal : {NormalLaw::hertz, NormalLaw::linear})
        for (int k = 0; k < 5000; ++k) {
            Laws laws;
            laws.normal = normal;
            laws.stiffness_n = 1000.0;
            auto g = at_rest({0, 1, 0});
            g.overlap = std::pow(10.0, random.uniform(-12.0, -4.0));
            g.parting_speed = random.uniform(-1.0, 1.0) * std::pow(10.0, random.uniform(-3.0, 3.0));
            const auto p = parameters(laws, random.uniform(0.05, 1.0), 0.5, 0.0);
            const auto evaluate = [&](double floor) { return normal == NormalLaw::hertz ? HertzNormal::evaluate(g, p, floor) : LinearNormal::evaluate(g, p, floor); };
            ASSERT_GE(evaluate(0.0).total, 0.0);
            attracted += evaluate(-HUGE_VAL).total < 0.0 ? 1 : 0;
            ASSERT_EQ(g.parting_speed < 0.0 && p.damping_n > 0.0, evaluate(-HUGE_VAL).total > evaluate(-HUGE_VAL).elastic);
        }
    EXPECT_GT(attracted, 1000);
}

template <class Tangential>
void expect_cap_and_zero() {
    Random random(4);
    for (int k = 0; k < 3000; ++k) {
        auto g = at_rest(unit_vector(random));
        g.slip_velocity = cross(g.normal, unit_vector(random)) * std::pow(10.0, random.uniform(-5.0, 1.0));
        g.parting_speed = random.uniform(-0.1, 0.1);
        const double friction = k % 3 == 0 ? 0.0 : random.uniform(0.0, 1.0);
        const auto p = parameters(Laws{}, 0.3, friction, 0.0);
        const auto n = HertzNormal::evaluate(g, p, 0.0);
        TangentialRow<double> row{cross(g.normal, unit_vector(random)) * 1e-4, n.contact_radius};
        for (int k_th = 0; k_th < 3; ++k_th) {
            const auto f = step<Tangential>(g, n, p.friction, row);
            const double cap = friction * n.total;
            ASSERT_LE(length(f.force), cap * (1.0 + 1e-14));
            ASSERT_NEAR(dot(f.force, g.normal), 0.0, 1e-12 * cap + 1e-25);
            ASSERT_TRUE(!f.sliding || std::fabs(length(f.force) - cap) <= 1e-14 * cap);
            ASSERT_EQ(f.sliding, row.last < 0.0) << "the sign of the stored radius tells sliding";
            ASSERT_EQ(std::fabs(row.last), n.contact_radius);
            if (cap > 0.0) continue;
            ASSERT_EQ(dot(f.force, f.force), 0.0) << "no friction or no normal force: no force";
            ASSERT_EQ(dot(row.vector, row.vector), 0.0) << "and no history";
        }
    }
}

TEST(Laws, the_tangential_force_lies_in_the_plane_keeps_to_the_coulomb_cap_and_vanishes_without_friction) {
    expect_cap_and_zero<ForceHistory<true>>();
    expect_cap_and_zero<ForceHistory<false>>();
    expect_cap_and_zero<DisplacementHistory>();
}

TEST(Laws, the_constant_torque_is_mu_r_R_F_against_the_rotation_and_falls_to_zero_below_its_rate) {
    const auto p = parameters(Laws{}, 0.5, 0.5, 0.1);
    auto g = at_rest({0, 1, 0});
    const auto n = HertzNormal::evaluate(g, p, 0.0);
    const double full = 0.1 * g.radius_eff * n.total;
    for (const double speed : {1e-2, 1.0, 300.0}) {
        g.rolling_rate = {speed, 0.0, 0.0};
        const auto m = ConstantRolling::evaluate(g, n, p, 1e-3, 0.0);
        EXPECT_NEAR(m.on_i.x, -full, 1e-13 * full);
        EXPECT_EQ(m.on_j.x, -m.on_i.x);
        EXPECT_EQ(m.on_i.y, 0.0);
    }
    g.rolling_rate = {0.0, 0.0, 0.5e-3};
    EXPECT_NEAR(ConstantRolling::evaluate(g, n, p, 1e-3, 0.0).on_i.z, -0.5 * full, 1e-13 * full);
    g.rolling_rate = {0.0, 0.0, 0.0};
    EXPECT_EQ(ConstantRolling::evaluate(g, n, p, 1e-3, 0.0).on_i.z, 0.0);
    // Never so large that one step would turn a grain's rotation round.
    g.rolling_rate = {1.0, 0.0, 0.0};
    const double dt = 1.0, inertia = 0.4 * g.mass_eff * g.radius_eff * g.radius_eff;
    EXPECT_LE(-ConstantRolling::evaluate(g, n, p, 1e-3, dt).on_i.x * dt, inertia * (1.0 + 1e-12));
}

TEST(Laws, the_rolling_spring_is_linear_at_first_and_ends_at_mu_r_R_F_without_damping) {
    const auto p = parameters(Laws{}, 0.5, 0.5, 0.1);
    auto g = at_rest({0, 1, 0});
    const auto n = HertzNormal::evaluate(g, p, 0.0);
    const double full = 0.1 * g.radius_eff * n.total, lever = 0.1 * g.radius_eff, stiffness = 2.25 * n.secant * lever * lever;
    g.rolling_rate = {1.0, 0.0, 0.0};
    Vec3d moment{0, 0, 0};
    const double small = 1e-9;
    auto m = step(g, n, p, small, moment);
    EXPECT_NEAR(moment.x, -stiffness * small, 1e-12 * stiffness * small);
    EXPECT_NEAR(m.on_i.x, moment.x - 2.0 * 0.3 * std::sqrt(g.rolling_inertia * stiffness), 1e-12 * full);
    for (int k = 0; k < 100; ++k) m = step(g, n, p, 1e-3, moment);
    EXPECT_NEAR(m.on_i.x, -full, 1e-13 * full);
    EXPECT_NEAR(moment.x, -full, 1e-13 * full);
    EXPECT_EQ(m.on_j.x, -m.on_i.x);
    g.overlap = 0.0;
    const auto open = HertzNormal::evaluate(g, p, 0.0);
    m = step(g, open, p, 1e-3, moment);
    EXPECT_EQ(m.on_i.x, 0.0);
    EXPECT_EQ(moment.x, 0.0);
}

TEST(Laws, the_rayleigh_step_of_the_papers_sand_is_8_85_to_10_79_microseconds) {
    // pi R sqrt(rho/G) / (0.1631 nu + 0.8766) by hand: G = 1e7/2.4 Pa, sqrt(rho/G) = 0.02497999 s/m, the denominator 0.90922.
    EXPECT_NEAR(rayleigh_step(kSand, 0.5 * 205.0e-6), 8.8470e-6, 0.0001e-6);
    EXPECT_NEAR(rayleigh_step(kSand, 0.5 * 250.0e-6), 10.7890e-6, 0.0001e-6);
}

TEST(Laws, a_rigid_wall_doubles_the_effective_modulus_of_equal_materials) {
    const Material rigid{0.0, 0.0, 0.0, true};
    EXPECT_NEAR(effective_young(kSand, rigid), 2.0 * effective_young(kSand, kSand), 1e-8);
    EXPECT_NEAR(effective_young(kSand, rigid), 1.0e7 / 0.96, 1e-6);
    EXPECT_EQ(effective_young(rigid, kSand), effective_young(kSand, rigid));
}

} // namespace
} // namespace talus::core
