// Sums without an order: the conversion from doubles to units, at its cap and at halves, and the sums over ranks of a serial engine.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "../support/bed.hpp"
#include "core/fixed_sum.hpp"
#include "core/simd.hpp"
#include "runtime/comm/communicator.hpp"

namespace talus::core {
namespace {

void expect_integer(double value, std::int64_t units) {
    EXPECT_EQ(to_integer(value, 1.0), units) << value;
    const I4 four = to_integer(V4{value, -value, 0.0, value}, splat<V4>(1.0));
    EXPECT_EQ(four[0], units) << value;
    EXPECT_EQ(four[1], -units) << value;
    EXPECT_EQ(four[2], 0);
    EXPECT_EQ(four[3], units) << value;
    EXPECT_TRUE(to_units(value, 1.0) == units) << value;
}

TEST(FixedSum, conversion_is_exact_at_the_cap_and_around_it) {
    const auto cap = static_cast<std::int64_t>(kCapUnits);
    ASSERT_EQ(cap, std::int64_t{1} << kCapBits);
    expect_integer(kCapUnits, cap);
    expect_integer(-kCapUnits, -cap);
    expect_integer(kCapUnits - 1.0, cap - 1);
    expect_integer(kCapUnits + 1.0, cap + 1);
    // One ulp below the cap is an eighth of a unit, one above a quarter: both round to it.
    EXPECT_EQ(std::nextafter(kCapUnits, 0.0), kCapUnits - 0.125);
    expect_integer(std::nextafter(kCapUnits, 0.0), cap);
    expect_integer(std::nextafter(kCapUnits, HUGE_VAL), cap);
}

TEST(FixedSum, conversion_holds_up_to_the_last_integer_below_two_to_the_51) {
    const std::int64_t last = (std::int64_t{1} << 51) - 1;
    expect_integer(static_cast<double>(last), last);
    expect_integer(-static_cast<double>(last), -last);
}

TEST(FixedSum, halves_round_to_even_on_both_sides_of_zero) {
    expect_integer(0.5, 0);
    expect_integer(1.5, 2);
    expect_integer(2.5, 2);
    expect_integer(3.5, 4);
    expect_integer(-0.5, 0);
    expect_integer(-1.5, -2);
    expect_integer(-2.5, -2);
    expect_integer(std::nextafter(0.5, 1.0), 1);
    expect_integer(std::nextafter(0.5, 0.0), 0);
    expect_integer(std::nextafter(-0.5, -1.0), -1);
    const double large = kCapUnits / 2.0;
    expect_integer(large + 0.5, static_cast<std::int64_t>(large));
    expect_integer(large + 1.5, static_cast<std::int64_t>(large) + 2);
    expect_integer(-large - 0.5, -static_cast<std::int64_t>(large));
}

TEST(FixedSum, zeros_of_both_signs_and_denormals_become_zero) {
    expect_integer(0.0, 0);
    expect_integer(-0.0, 0);
    expect_integer(5e-324, 0);
}

TEST(FixedSum, one_and_four_lanes_round_alike_over_the_whole_range) {
    test::Random random(3);
    for (int k = 0; k < 20000; ++k) {
        V4 v;
        for (int l = 0; l < 4; ++l) v[l] = std::ldexp(random.uniform(-1.0, 1.0), static_cast<int>(random.uniform(-3.0, 50.99)));
        const I4 four = to_integer(v, splat<V4>(1.0));
        for (int l = 0; l < 4; ++l) {
            ASSERT_EQ(four[l], to_integer(v[l], 1.0));
            ASSERT_EQ(four[l], std::llrint(v[l]));
        }
    }
}

TEST(FixedSum, a_unit_is_a_power_of_two_with_the_cap_just_within_two_to_the_50_units) {
    for (const double cap : {1.0, 1.5, 3.7e-9, 2.0, std::nextafter(2.0, 3.0), std::nextafter(2.0, 1.0), 1e18, 0.125}) {
        const FixedUnit u = FixedUnit::for_cap(cap);
        int exponent = 0;
        EXPECT_EQ(std::frexp(u.unit, &exponent), 0.5) << "a power of two";
        EXPECT_EQ(u.unit * u.scale, 1.0);
        EXPECT_LE(cap * u.scale, kCapUnits) << cap;
        EXPECT_GE(cap * u.scale, kCapUnits / 2.0) << cap;
    }
}

TEST(FixedSum, the_units_of_torques_have_room_for_the_cap_at_the_end_of_their_arms) {
    const FixedUnits u = FixedUnits::make(12.0, 0.003, 0.7);
    EXPECT_LE(12.0 * u.force.scale, kCapUnits);
    EXPECT_LE(12.0 * 0.003 * u.torque.scale, kCapUnits);
    EXPECT_LE(12.0 * 0.7 * u.wall_torque.scale, kCapUnits);
    const FixedUnits small = FixedUnits::make(12.0, 0.003, 0.0);
    EXPECT_LE(12.0 * 0.003 * small.wall_torque.scale, kCapUnits);
}

TEST(FixedSum, a_sum_of_as_many_contributions_as_are_allowed_at_the_cap_does_not_overflow) {
    std::int64_t sum = 0;
    for (int k = 0; k + 1 < static_cast<int>(kMaxContributions); ++k) ASSERT_FALSE(__builtin_add_overflow(sum, to_integer(kCapUnits, 1.0), &sum));
    EXPECT_GT(sum, 0);
}

TEST(FixedSum, sums_do_not_depend_on_the_order_while_sums_of_doubles_do) {
    test::Random random(5);
    std::vector<double> values;
    for (int k = 0; k < 1000; ++k) values.push_back(std::ldexp(random.uniform(-1.0, 1.0), static_cast<int>(random.uniform(0.0, 50.0))));
    const auto integer_sum = [&] { return std::accumulate(values.begin(), values.end(), std::int64_t{0}, [](std::int64_t s, double v) { return s + to_integer(v, 1.0); }); };
    const auto double_sum = [&] { return std::accumulate(values.begin(), values.end(), 0.0, [](double s, double v) { return s + v * 0.1; }); };
    const std::int64_t first = integer_sum();
    const double first_double = double_sum();
    bool doubles_differ = false;
    for (int shuffle = 0; shuffle < 50; ++shuffle) {
        for (std::size_t k = values.size() - 1; k > 0; --k) std::swap(values[k], values[static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(k + 1)))]);
        ASSERT_EQ(integer_sum(), first);
        doubles_differ = doubles_differ || double_sum() != first_double;
    }
    EXPECT_TRUE(doubles_differ) << "otherwise this test shows nothing";
}

TEST(FixedSum, the_error_of_a_conversion_is_at_most_half_a_unit) {
    const FixedUnit u = FixedUnit::for_cap(3.0);
    test::Random random(9);
    for (int k = 0; k < 1000; ++k) {
        const double v = random.uniform(-3.0, 3.0);
        EXPECT_LE(std::fabs(to_double(to_integer(v, u.scale), u.unit) - v), 0.5 * u.unit);
    }
}

TEST(FixedSum, wide_sums_pass_a_serial_communicator_unchanged) {
    runtime::Communicator serial;
    Wide v[4] = {-1, (static_cast<Wide>(1) << 100) + 12345, -(static_cast<Wide>(1) << 90), static_cast<Wide>(INT64_MIN) - 7};
    Wide before[4];
    std::copy(v, v + 4, before);
    serial.sum(v, 4);
    for (int k = 0; k < 4; ++k) EXPECT_TRUE(v[k] == before[k]) << k;
    EXPECT_EQ(serial.sum(std::int64_t{-5}), -5);
    EXPECT_EQ(serial.sum_modulo(~std::uint64_t{0}), ~std::uint64_t{0});
}

TEST(FixedSum, units_have_room_for_the_cap_they_were_made_with_and_tell_how_much_more) {
    test::Random random(12);
    for (int k = 0; k < 1000; ++k) {
        const double cap = std::pow(10.0, random.uniform(-9.0, 6.0)), radius = std::pow(10.0, random.uniform(-5.0, 0.0)), extent = std::pow(10.0, random.uniform(-4.0, 2.0));
        const FixedUnits u = FixedUnits::make(cap, radius, extent);
        const double most = most_force(u, radius, extent);
        EXPECT_GE(most, cap * (1.0 - 1e-15));
        EXPECT_LE(most, 2.0 * cap * (1.0 + 1e-15));
        // Each product at that cap is within the units' own.
        EXPECT_LE(most, kCapUnits * u.force.unit * (1.0 + 1e-15));
        EXPECT_LE(most * radius, kCapUnits * u.torque.unit * (1.0 + 1e-15));
        EXPECT_LE(2.0 * most * std::max(extent, radius), kCapUnits * u.wall_torque.unit * (1.0 + 1e-15));
    }
}

} // namespace
} // namespace talus::core
