// The balancer: whatever the field and the cuts it starts from, subdomains end up with the same cost, in few rebalances.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "../support/bed.hpp"
#include "core/balance.hpp"

namespace talus::core {
namespace {

struct Point {
    double x[3];
    std::int64_t cost;
};
using Field = std::vector<Point>;

Domain domain_of(double x, double y, double z) {
    Domain d;
    d.hi[0] = x;
    d.hi[1] = y;
    d.hi[2] = z;
    return d;
}

/// One rebalance: as the engine does it, with the whole field in one process.
SliceGrid rebalanced(const SliceGrid& now, const Field& field, const Domain& d, const CutLimits& limits) {
    const Box extent{{d.lo[0], d.lo[1], d.lo[2]}, {d.hi[0], d.hi[1], d.hi[2]}};
    return balance(now, extent, limits, [&](CostProfile& profile) {
        for (const Point& p : field) profile.add(p.x, p.cost);
    });
}

double max_over_mean(const SliceGrid& cuts, const Field& field) {
    std::vector<std::int64_t> cost(static_cast<std::size_t>(cuts.n_ranks()), 0);
    std::int64_t total = 0;
    for (const Point& p : field) {
        cost[static_cast<std::size_t>(cuts.owner(p.x))] += p.cost;
        total += p.cost;
    }
    return static_cast<double>(*std::max_element(cost.begin(), cost.end())) * cuts.n_ranks() / static_cast<double>(total);
}

/// A bed of random places with a surface and a density. @param cost_at  cost of a grain, zero where there is none
template <class CostAt>
Field make_field(int n, const Domain& d, CostAt cost_at) {
    test::Random random(7);
    Field field;
    while (static_cast<int>(field.size()) < n) {
        Point p{{random.uniform(0.0, d.hi[0]), random.uniform(0.0, d.hi[1]), random.uniform(0.0, d.hi[2])}, 0};
        p.cost = cost_at(p.x);
        if (p.cost > 0) field.push_back(p);
    }
    return field;
}

std::int64_t flat(const double* x) { return x[1] < 0.2 ? 100 : 0; }
std::int64_t prism(const double* x) { return x[1] < 0.2 + 0.6 * std::max(0.0, 1.0 - x[0] / 2.0) ? 100 : 0; } // a wedge at one end
std::int64_t step(const double* x) { return x[1] >= 0.2 ? 0 : x[0] + 0.7 * x[2] < 2.0 ? 1000 : 100; }        // ten to one, oblique

TEST(Balance, equal_volumes_become_equal_costs_in_one_rebalance_for_any_field) {
    const Domain d = domain_of(4.0, 1.0, 3.0);
    for (auto* field_of : {flat, prism, step}) {
        const Field field = make_field(200000, d, field_of);
        for (const auto& grid : {std::array{6, 1, 1}, std::array{8, 1, 8}, std::array{4, 2, 4}}) {
            SliceGrid cuts(d, grid);
            const double before = max_over_mean(cuts, field);
            cuts = rebalanced(cuts, field, d, {});
            const double once = max_over_mean(cuts, field);
            for (int k = 0; k < 3; ++k) cuts = rebalanced(cuts, field, d, {});
            const double settled = max_over_mean(cuts, field);
            // A part holds 200,000/64 points and the largest of them costs a thousandth of it or less.
            EXPECT_LE(once, 1.03) << before;
            EXPECT_LE(settled, 1.02);
        }
    }
}

TEST(Balance, with_cuts_held_to_a_halo_width_it_gets_there_in_as_many_rebalances_as_the_way_takes) {
    const Domain d = domain_of(4.0, 1.0, 3.0);
    const Field field = make_field(100000, d, step);
    const std::array grid{8, 1, 4};
    const double halo = 0.05;
    const SliceGrid start(d, grid), goal = rebalanced(rebalanced(start, field, d, {}), field, d, {});
    double way = 0.0; // along x, then, where slabs stand by now, along z
    for (const int axis : {0, 2}) {
        double longest = 0.0;
        for (std::size_t k = 0; k < goal.cuts(axis).size(); ++k) longest = std::max(longest, std::fabs(goal.cuts(axis)[k] - start.cuts(axis)[k]));
        way += longest;
    }
    SliceGrid cuts = start;
    int used = 0;
    while (max_over_mean(cuts, field) > 1.03 && used < 100) {
        const SliceGrid next = rebalanced(cuts, field, d, {0.0, halo});
        for (const int axis : {0, 2})
            for (std::size_t k = 0; k < next.cuts(axis).size(); ++k) EXPECT_LE(std::fabs(next.cuts(axis)[k] - cuts.cuts(axis)[k]), halo * (1.0 + 1e-9));
        cuts = next;
        ++used;
    }
    EXPECT_GE(used, 5) << "the way is long, or this shows nothing";
    EXPECT_LE(used, std::ceil(way / halo) + 4);
}

TEST(Balance, cuts_do_not_wander_when_nothing_changes) {
    const Domain d = domain_of(4.0, 1.0, 3.0);
    const Field field = make_field(100000, d, prism);
    SliceGrid cuts(d, {4, 1, 4});
    for (int k = 0; k < 5; ++k) cuts = rebalanced(cuts, field, d, {});
    SliceGrid later = cuts;
    for (int k = 0; k < 5; ++k) later = rebalanced(later, field, d, {});
    for (const int axis : {0, 2})
        for (std::size_t k = 0; k < cuts.cuts(axis).size(); ++k) EXPECT_NEAR(later.cuts(axis)[k], cuts.cuts(axis)[k], 1e-3);
}

TEST(Balance, cost_in_a_corner_of_a_wide_domain_is_found) {
    // Nine tenths of the domain empty, and present cuts that all lie where there is nothing.
    const Domain d = domain_of(100.0, 1.0, 1.0);
    test::Random random(3);
    Field field;
    for (int k = 0; k < 50000; ++k) field.push_back({{random.uniform(7.0, 7.5), random.uniform(0.0, 1.0), random.uniform(0.0, 1.0)}, 10});
    SliceGrid cuts(d, {8, 1, 1});
    EXPECT_EQ(max_over_mean(cuts, field), 8.0);
    cuts = rebalanced(cuts, field, d, {});
    EXPECT_LE(max_over_mean(cuts, field), 1.02);
}

TEST(Balance, parts_keep_their_least_width_wherever_the_cost_stands) {
    const Domain d = domain_of(1.0, 1.0, 1.0);
    for (int where = 0; where < 100; where += 9) {
        const Field field{{{0.01 * where, 0.5, 0.5}, 1000}};
        SliceGrid cuts(d, {5, 1, 1});
        for (int k = 0; k < 3; ++k) {
            cuts = rebalanced(cuts, field, d, {0.15});
            double before = 0.0;
            for (const double c : cuts.cuts(0)) {
                EXPECT_GE(c - before, 0.15 - 1e-12);
                before = c;
            }
            EXPECT_GE(1.0 - before, 0.15 - 1e-12);
        }
    }
}

TEST(Balance, without_any_cost_parts_are_equal) {
    const Domain d = domain_of(8.0, 1.0, 4.0);
    const SliceGrid cuts = rebalanced(SliceGrid(d, {4, 1, 2}), {}, d, {0.1});
    EXPECT_EQ(cuts.cuts(0), (std::vector<double>{2.0, 4.0, 6.0}));
    EXPECT_EQ(cuts.cuts(2), (std::vector<double>{2.0, 2.0, 2.0, 2.0}));
}

TEST(Balance, cuts_outside_of_what_is_left_of_a_shrinking_box_come_back) {
    const Domain d = domain_of(4.0, 1.0, 1.0);
    test::Random random(5);
    Field field;
    for (int k = 0; k < 20000; ++k) field.push_back({{random.uniform(2.0, 4.0), 0.5, 0.5}, 10});
    SliceGrid cuts(d, {4, 1, 1});
    const Box extent{{2.0, 0.5, 0.5}, {4.0, 0.5, 0.5}};
    cuts = balance(cuts, extent, {0.05}, [&](CostProfile& profile) {
        for (const Point& p : field) profile.add(p.x, p.cost);
    });
    EXPECT_LE(max_over_mean(cuts, field), 1.02);
    EXPECT_GT(cuts.cuts(0).front(), 2.0);
}

TEST(Balance, costs_of_billions_of_grains_do_not_overflow) {
    const Domain d = domain_of(1.0, 1.0, 1.0);
    Field field; // 64 places of 2.4e9/64 grains, each of 10^5 units
    for (int k = 0; k < 64; ++k) field.push_back({{(k + 0.5) / 64, 0.5, 0.5}, std::int64_t{2'400'000'000} / 64 * 100'000});
    const SliceGrid cuts = rebalanced(SliceGrid(d, {2, 1, 1}), field, d, {});
    EXPECT_NEAR(cuts.cuts(0)[0], 0.5, 1.0 / 64);
}

TEST(BalanceLedger, cuts_move_when_what_imbalance_took_exceeds_what_a_move_took_and_not_for_noise) {
    BalanceLedger ledger;
    EXPECT_FALSE(ledger.pays());
    ledger.add_price(1.0);
    ledger.add(1.2, 1.0, 5.0); // 5 steps, each 0.19 s longer than it could be
    EXPECT_FALSE(ledger.pays());
    ledger.add(1.2, 1.0, 0.3);
    EXPECT_TRUE(ledger.pays());
    ledger.moved();
    EXPECT_FALSE(ledger.pays());
    // What lies within the noise of a measurement is forgiven, and so is what was before it.
    ledger.add(1.2, 1.0, 5.0);
    ledger.add(1.02, 1.0, 1e6);
    ledger.add(1.2, 1.0, 5.0);
    EXPECT_FALSE(ledger.pays());
    ledger.add(1.2, 1.0, 1.0);
    EXPECT_TRUE(ledger.pays());
}

} // namespace
} // namespace talus::core
