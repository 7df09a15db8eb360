// The force kernels: every width gives the bits of the scalar reference, in every law, with and without the energy ledger.
#include <gtest/gtest.h>

#include "../support/kernel_bench.hpp"

namespace talus::core {
namespace {

using test::KernelBench;
using test::all_laws;
using test::name_of;
using test::numbers;
using test::open_contacts;

void expect_equal(const KernelBench& a, const KernelBench& b) {
    EXPECT_EQ(numbers(a.tile.sums), numbers(b.tile.sums));
    EXPECT_EQ(open_contacts(a.tile.pairs), open_contacts(b.tile.pairs));
    for (std::size_t w = 0; w < a.walls.size(); ++w) {
        EXPECT_EQ(open_contacts(a.tile.walls[w]), open_contacts(b.tile.walls[w]));
        EXPECT_EQ(a.tile.wall_sums[w].contacts, b.tile.wall_sums[w].contacts);
        for (int c = 0; c < 3; ++c) {
            EXPECT_TRUE(a.tile.wall_sums[w].force[c] == b.tile.wall_sums[w].force[c]);
            EXPECT_TRUE(a.tile.wall_sums[w].torque[c] == b.tile.wall_sums[w].torque[c]);
        }
    }
    EXPECT_TRUE(a.heat.friction == b.heat.friction && a.heat.damping == b.heat.damping && a.heat.rolling == b.heat.rolling);
    EXPECT_EQ(a.breach.found, b.breach.found);
    EXPECT_EQ(a.breach.i, b.breach.i);
    EXPECT_EQ(a.breach.j, b.breach.j);
}

/// What this machine and build have beside the scalar reference.
std::vector<KernelWidth> vector_widths() {
    std::vector<KernelWidth> widths{KernelWidth::four};
    if (has_width(KernelWidth::eight)) widths.push_back(KernelWidth::eight);
    return widths;
}

std::vector<KernelWidth> all_widths() {
    std::vector<KernelWidth> widths = vector_widths();
    widths.push_back(KernelWidth::scalar);
    return widths;
}

TEST(Kernels, every_width_gives_the_bits_of_one_lane_in_every_law_with_and_without_the_ledger) {
    int combinations = 0;
    for (const Laws& laws : all_laws())
        for (const bool ledger : {false, true}) {
            SCOPED_TRACE(name_of(laws) + (ledger ? ", ledger" : ""));
            // Numbers of pairs that leave every length of tail behind.
            const int n_pairs = 150 + combinations % 9;
            KernelBench scalar(laws, 40, n_pairs, 1 + combinations % 3, static_cast<std::uint64_t>(combinations));
            scalar.context.ledger = ledger;
            std::vector<KernelBench> vectors(vector_widths().size(), scalar);
            int least = n_pairs, most = 0;
            for (int step = 0; step < 12; ++step) {
                scalar.clear_sums();
                scalar.evaluate(KernelWidth::scalar);
                for (std::size_t w = 0; w < vectors.size(); ++w) {
                    vectors[w].clear_sums();
                    vectors[w].evaluate(vector_widths()[w]);
                    expect_equal(scalar, vectors[w]);
                    vectors[w].drift(2.0e-4);
                }
                const auto open = static_cast<int>(open_contacts(scalar.tile.pairs).size());
                least = std::min(least, open);
                most = std::max(most, open);
                scalar.drift(2.0e-4);
            }
            EXPECT_FALSE(scalar.breach.found);
            EXPECT_GT(least, 8);
            EXPECT_LT(most, n_pairs - 8) << "some candidates must not touch";
            EXPECT_GT(scalar.tile.wall_sums[0].contacts + scalar.tile.wall_sums[1].contacts, 4);
            EXPECT_EQ(ledger, scalar.heat.damping != 0);
            if (HasFailure()) return;
            ++combinations;
        }
    EXPECT_EQ(combinations, 2 * 2 * 2 * 4 * 5 * 2);
}

TEST(Kernels, every_number_of_pairs_up_to_three_batches_gives_the_same_bits_at_every_width) {
    Laws laws;
    laws.rolling = RollingLaw::spring;
    for (int n_pairs = 0; n_pairs <= 25; ++n_pairs) {
        SCOPED_TRACE(n_pairs);
        KernelBench scalar(laws, 12, n_pairs, 2, 77);
        const KernelBench before = scalar;
        scalar.evaluate(KernelWidth::scalar);
        std::vector<KernelWidth> widths = vector_widths();
        widths.push_back(KernelWidth::automatic);
        for (const KernelWidth width : widths) {
            KernelBench vector = before;
            vector.evaluate(width);
            expect_equal(scalar, vector);
        }
    }
}

/// Contacts open before and after keep their rows to the bit; one that is new has a row of zeros.
void expect_histories_kept(const ContactList& before, const ContactList& after) {
    int kept = 0;
    const auto open = open_contacts(before);
    for (const auto& [pair, row] : open_contacts(after)) {
        const auto found = open.find(pair);
        kept += found != open.end() ? 1 : 0;
        EXPECT_EQ(row, found != open.end() ? found->second : std::vector<std::uint64_t>(row.size(), 0)) << "contact of " << pair.first << " and " << pair.second;
    }
    EXPECT_GT(kept, 0);
}

TEST(Kernels, an_evaluation_that_does_not_advance_changes_no_history_of_an_open_contact) {
    for (const Laws& laws : all_laws())
        for (const KernelWidth width : all_widths()) {
            SCOPED_TRACE(name_of(laws));
            KernelBench bench(laws, 40, 150, 2, 5);
            bench.evaluate(width);
            bench.drift(5.0e-4);
            const ContactList pairs = bench.tile.pairs, wall = bench.tile.walls[0];
            bench.clear_sums();
            bench.context.advance = false;
            bench.evaluate(width);
            expect_histories_kept(pairs, bench.tile.pairs);
            expect_histories_kept(wall, bench.tile.walls[0]);
            const auto sums = numbers(bench.tile.sums);
            EXPECT_NE(std::count(sums.begin(), sums.end(), 0), static_cast<std::ptrdiff_t>(sums.size())) << "forces are computed all the same";
            bench.clear_sums();
            bench.evaluate(width);
            EXPECT_EQ(numbers(bench.tile.sums), sums) << "and again alike";
            if (HasFailure()) return;
        }
}

TEST(Kernels, internal_forces_sum_to_integer_zero_in_every_law) {
    for (const Laws& laws : all_laws()) {
        SCOPED_TRACE(name_of(laws));
        KernelBench bench(laws, 40, 200, 3, 9);
        for (int step = 0; step < 5; ++step) {
            bench.evaluate(KernelWidth::automatic, false);
            std::int64_t sum[3] = {0, 0, 0}, size = 0;
            for (const ForceSum& s : bench.tile.sums)
                for (int c = 0; c < 3; ++c) {
                    sum[c] += s.force[c];
                    size += std::abs(s.force[c]);
                }
            for (const std::int64_t s : sum) EXPECT_EQ(s, 0);
            EXPECT_GT(size, 1000000);
            bench.drift(1.0e-4);
        }
    }
}

TEST(Kernels, grains_and_walls_together_sum_to_integer_zero) {
    KernelBench bench(Laws{}, 40, 200, 3, 9);
    bench.evaluate(KernelWidth::automatic);
    for (int c = 0; c < 3; ++c) {
        Wide sum = bench.tile.wall_sums[0].force[c] + bench.tile.wall_sums[1].force[c];
        EXPECT_TRUE(bench.tile.wall_sums[0].force[c] != 0);
        for (const ForceSum& s : bench.tile.sums) sum += s.force[c];
        EXPECT_TRUE(sum == 0);
    }
}

TEST(Kernels, sums_are_the_same_in_any_order_of_pairs) {
    KernelBench one(Laws{}, 40, 150, 2, 33);
    KernelBench other = one;
    std::reverse(other.tile.pairs.candidates.begin(), other.tile.pairs.candidates.begin() + other.tile.pairs.n_candidates);
    one.evaluate(KernelWidth::automatic);
    other.evaluate(KernelWidth::automatic);
    EXPECT_EQ(numbers(one.tile.sums), numbers(other.tile.sums));
}

TEST(Kernels, a_contact_that_opens_and_closes_again_starts_from_a_void_history) {
    KernelBench bench(Laws{}, 2, 0, 1, 1);
    Particle &a = bench.particles[0], &b = bench.particles[1];
    bench.list(0, 1);
    for (int c = 0; c < 3; ++c) b.position[c] = a.position[c] = 5.0e-3;
    b.position[1] += 0.95 * (a.radius + b.radius);
    a.velocity[0] = 1.0;
    bench.context.pairs[0][0].friction = 1e6;
    const auto first_step = [&] {
        bench.clear_sums();
        bench.evaluate(KernelWidth::automatic, false);
        return numbers(bench.tile.sums);
    };
    const auto fresh = first_step();
    ASSERT_EQ(open_contacts(bench.tile.pairs).size(), 1u);
    EXPECT_NE(first_step(), fresh) << "the second step has a history";
    b.position[1] += a.radius;
    first_step();
    EXPECT_TRUE(open_contacts(bench.tile.pairs).empty());
    b.position[1] -= a.radius;
    b.position[1] = a.position[1] + 0.95 * (a.radius + b.radius);
    EXPECT_EQ(first_step(), fresh);
}

TEST(Kernels, a_force_at_the_cap_is_summed_and_one_above_it_is_reported_with_the_pair_and_left_out) {
    for (const KernelWidth width : all_widths()) {
        Laws laws;
        laws.normal = NormalLaw::linear;
        laws.tangential = TangentialLaw::none;
        laws.rolling = RollingLaw::none;
        laws.stiffness_n = 1.0;
        KernelBench bench(laws, 2, 0, 1, 1);
        Particle &a = bench.particles[0], &b = bench.particles[1];
        a.label = 12;
        b.label = 5;
        a.radius = b.radius = 0.5e-3;
        for (int c = 0; c < 3; ++c) {
            a.position[c] = b.position[c] = 8.0e-3;
            a.velocity[c] = b.velocity[c] = 0.0;
        }
        a.position[2] = 0.0;
        b.position[2] = 0.5e-3; // an overlap of 0.5e-3: the force is then exactly stiffness * overlap
        bench.list(0, 1);
        bench.context.pairs[0][0].damping_n = 0.0;
        bench.context.pairs[0][0].stiffness_n = 2.0;
        const double force = 2.0 * ((0.5e-3 + 0.5e-3) - 0.5e-3);
        bench.context.units.force = FixedUnit{force / kCapUnits, kCapUnits / force}; // no power of two: the cap then is this very force
        ASSERT_EQ(force * bench.context.units.force.scale, kCapUnits);
        bench.evaluate(width, false);
        EXPECT_FALSE(bench.breach.found);
        EXPECT_EQ(bench.tile.sums[1].force[2], static_cast<std::int64_t>(kCapUnits));
        EXPECT_EQ(bench.tile.sums[0].force[2], -static_cast<std::int64_t>(kCapUnits));

        bench.clear_sums();
        bench.context.pairs[0][0].stiffness_n = std::nextafter(2.0, 3.0);
        bench.evaluate(width, false);
        EXPECT_TRUE(bench.breach.found);
        EXPECT_EQ(bench.breach.i, 5);
        EXPECT_EQ(bench.breach.j, 12);
        EXPECT_NEAR(bench.breach.force, force, 1e-12 * force);
        EXPECT_EQ(bench.tile.sums[1].force[2], 0);
    }
}

TEST(Kernels, a_velocity_that_is_not_a_number_is_a_breach_that_names_its_grain) {
    for (const KernelWidth width : all_widths()) {
        KernelBench bench(Laws{}, 40, 150, 2, 4);
        bench.evaluate(width, false);
        ASSERT_FALSE(bench.breach.found);
        Particle& bad = bench.particles[3];
        bad.velocity[1] = NAN;
        bench.clear_sums();
        bench.evaluate(width, false);
        ASSERT_TRUE(bench.breach.found);
        EXPECT_TRUE(bench.breach.i == bad.label || bench.breach.j == bad.label);
    }
}

TEST(Kernels, the_breach_named_is_the_one_with_the_smallest_labels_whatever_the_order) {
    KernelBench one(Laws{}, 40, 150, 1, 8);
    one.context.units.force = FixedUnit::for_cap(1e-9);
    KernelBench other = one;
    std::reverse(other.tile.pairs.candidates.begin(), other.tile.pairs.candidates.begin() + other.tile.pairs.n_candidates);
    one.evaluate(KernelWidth::four, false);
    other.evaluate(KernelWidth::scalar, false);
    ASSERT_TRUE(one.breach.found);
    EXPECT_EQ(one.breach.i, other.breach.i);
    EXPECT_EQ(one.breach.j, other.breach.j);
}

} // namespace
} // namespace talus::core
