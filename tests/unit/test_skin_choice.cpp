// The choice of the list skin: against a brute-force minimum of its model, its limits, and where it leads.
#include <gtest/gtest.h>

#include <cmath>

#include "../support/bed.hpp"
#include "core/skin_choice.hpp"

namespace talus::core {
namespace {

constexpr double kUnlimited = 1e9;

/// A settled bed of 50,000 grains, moving so that a skin of a tenth of the diameter lasts `steps` steps.
SkinModel bed(double steps) {
    SkinModel m;
    m.diameter = 2.5e-3;
    m.skin = 0.1 * m.diameter;
    m.grains = 50000;
    m.contacts = 144000;
    m.candidates = 212000;
    m.near_rate = m.skin / (steps + kLateSteps);
    m.far_rate = m.near_rate;
    return m;
}

SkinModel random_model(test::Random& random) {
    SkinModel m;
    m.diameter = std::exp(random.uniform(-9.0, 0.0));
    m.skin = m.diameter * std::exp(random.uniform(std::log(kLeastSkin), std::log(kMostSkin)));
    m.grains = std::exp(random.uniform(1.0, 15.0));
    m.contacts = m.grains * random.uniform(0.0, 3.0);
    m.candidates = m.contacts + m.grains * random.uniform(0.0, 3.0);
    m.near_rate = m.skin / std::exp(random.uniform(0.0, 8.0));
    m.far_rate = m.near_rate * random.uniform(1.0, 10.0);
    m.force_unit *= std::exp(random.uniform(-1.5, 1.5));
    return m;
}

TEST(SkinChoice, the_fastest_skin_takes_no_more_time_than_the_best_of_ten_thousand_skins_but_for_half_a_per_cent) {
    test::Random random(3);
    for (int n = 0; n < 300; ++n) {
        const SkinModel m = random_model(random);
        const double most = m.diameter * random.uniform(0.0, 0.7), chosen = fastest_skin(m, most);
        const double last = std::max(kFirstSkin, std::min(most / m.diameter, kMostSkin));
        double best = HUGE_VAL;
        for (int k = 0; k <= 10000; ++k) {
            const double s = m.diameter * (kLeastSkin + (last - kLeastSkin) * k / 10000);
            if (s <= kFirstSkin * m.diameter || m.candidates_at(s) <= kMostCandidates * m.grains) best = std::min(best, m.time(s));
        }
        EXPECT_LE(m.time(chosen), 1.005 * best) << "model " << n;
        EXPECT_GE(chosen, kLeastSkin * m.diameter);
        EXPECT_LE(chosen, last * m.diameter);
    }
}

TEST(SkinChoice, faster_motion_asks_for_a_wider_skin_and_rest_for_the_narrowest) {
    double before = 1.0;
    for (const double steps : {5.0, 30.0, 100.0, 1000.0}) {
        const SkinModel m = bed(steps);
        const double s = fastest_skin(m, kUnlimited) / m.diameter;
        EXPECT_LT(s, before) << steps << " steps";
        before = s;
    }
    SkinModel still = bed(100);
    still.near_rate = still.far_rate = 0.0;
    EXPECT_EQ(fastest_skin(still, kUnlimited), kLeastSkin * still.diameter);
}

TEST(SkinChoice, a_skin_changes_by_a_bounded_factor_and_comes_to_rest_at_about_the_fastest) {
    test::Random random(5);
    for (int n = 0; n < 100; ++n) {
        SkinModel m = random_model(random);
        const double goal = fastest_skin(m, kUnlimited), candidates = m.candidates, listed = m.skin;
        const SkinModel counted = m;
        for (int k = 0; k < 20; ++k) {
            const double next = next_skin(m, kUnlimited), ratio = next / m.skin;
            EXPECT_GE(ratio, 1.0 / kSkinFactor - 1e-12);
            EXPECT_LE(ratio, kSkinFactor + 1e-12);
            EXPECT_TRUE(k <= 12 || next == m.skin) << "model " << n << " does not come to rest";
            m.skin = next;
            m.candidates = counted.candidates_at(next);
        }
        EXPECT_LE((1.0 - kSkinGain) * m.time(m.skin), m.time(goal)) << "from " << listed << " with " << candidates << " candidates";
    }
}

TEST(SkinChoice, a_limit_holds_and_never_forbids_the_first_skin) {
    const SkinModel m = bed(5);
    EXPECT_GT(fastest_skin(m, kUnlimited), 0.16 * m.diameter);
    EXPECT_DOUBLE_EQ(fastest_skin(m, 0.15 * m.diameter), 0.15 * m.diameter);
    EXPECT_DOUBLE_EQ(fastest_skin(m, 0.0), kFirstSkin * m.diameter);
    SkinModel wide = m;
    wide.skin = 0.4 * m.diameter;
    EXPECT_LE(next_skin(wide, 0.15 * m.diameter), 0.15 * m.diameter) << "also when the list was wider";
    EXPECT_LE(m.candidates_at(fastest_skin(bed(1), kUnlimited)), (1.0 + 1e-9) * kMostCandidates * m.grains);
}

TEST(SkinChoice, a_list_is_outlived_when_its_excess_has_cost_as_much_as_a_rebuild) {
    SkinModel m = bed(1e6);
    const double next = next_skin(m, kUnlimited), excess = m.time(m.skin) - m.time(next);
    ASSERT_LT(next, m.skin);
    EXPECT_FALSE(outlived(m, kUnlimited, 0.9 * m.rebuild(next) / excess));
    EXPECT_TRUE(outlived(m, kUnlimited, 1.1 * m.rebuild(next) / excess));
    m.skin = fastest_skin(m, kUnlimited);
    EXPECT_FALSE(outlived(m, kUnlimited, 1e12)) << "nothing is better than the fastest";
}

TEST(SkinChoice, units_are_learnt_slowly_and_nonsense_teaches_nothing) {
    SkinModel m = bed(20);
    const double force = m.force(m.skin), rebuild = m.rebuild(m.skin);
    m.learn(1e6 * force, 2.0 * rebuild);
    EXPECT_NEAR(m.force(m.skin), 1.75 * force, 1e-9 * force) << "a slip of the clock counts as a factor of four at most";
    EXPECT_NEAR(m.rebuild(m.skin), 1.25 * rebuild, 1e-9 * rebuild);
    for (int k = 0; k < 60; ++k) m.learn(3.0 * force, 5.0 * rebuild);
    EXPECT_NEAR(m.force(m.skin), 3.0 * force, 1e-3 * force);
    EXPECT_NEAR(m.rebuild(m.skin), 5.0 * rebuild, 1e-3 * rebuild);
    const double unit = m.force_unit;
    for (const double bad : {0.0, -1.0, HUGE_VAL, static_cast<double>(NAN)}) m.learn(bad, bad);
    EXPECT_EQ(m.force_unit, unit);
}

} // namespace
} // namespace talus::core
