// The random numbers: known answers of Random123 (kat_vectors), and how a number is keyed.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "core/philox.hpp"

namespace talus::core {
namespace {

using Words = std::array<std::uint32_t, 4>;

/// Philox4x32-10 written out from Salmon et al. (2011), section 3.3.
Words philox(Words c, std::uint32_t k0, std::uint32_t k1) {
    for (int round = 0; round < 10; ++round) {
        const std::uint64_t a = 0xD2511F53ull * c[0], b = 0xCD9E8D57ull * c[2];
        c = {static_cast<std::uint32_t>(b >> 32) ^ c[1] ^ k0, static_cast<std::uint32_t>(b), static_cast<std::uint32_t>(a >> 32) ^ c[3] ^ k1, static_cast<std::uint32_t>(a)};
        k0 += 0x9E3779B9u;
        k1 += 0xBB67AE85u;
    }
    return c;
}

TEST(Philox, gives_the_known_answers_of_random123) {
    const auto library = [](Words c, std::uint32_t k0, std::uint32_t k1) {
        const r123::Philox4x32::ctr_type r = r123::Philox4x32{}({{c[0], c[1], c[2], c[3]}}, {{k0, k1}});
        return Words{r[0], r[1], r[2], r[3]};
    };
    const std::uint32_t f = 0xffffffffu;
    const Words zeros{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}, ones{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}, pi{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1};
    EXPECT_EQ(library({0, 0, 0, 0}, 0, 0), zeros);
    EXPECT_EQ(library({f, f, f, f}, f, f), ones);
    EXPECT_EQ(library({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, 0xa4093822, 0x299f31d0), pi);
    EXPECT_EQ(philox({0, 0, 0, 0}, 0, 0), zeros) << "the reference of the next test";
    EXPECT_EQ(philox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, 0xa4093822, 0x299f31d0), pi);
}

TEST(Philox, a_number_is_keyed_by_all_of_seed_stream_and_item) {
    const std::uint64_t seed = 0x0123456789abcdefull, item = 0xfedcba9876543210ull;
    const Words w = philox({0x76543210u, 0xfedcba98u, 2u, 0u}, 0x89abcdefu, 0x01234567u);
    const auto r = random_unit(seed, RandomStream::random_cuts, item);
    for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(r[k], w[k] / 4294967296.0);
}

TEST(Philox, numbers_lie_in_zero_to_one_with_the_mean_and_variance_of_a_uniform_distribution) {
    double sum = 0.0, square = 0.0;
    std::set<double> different;
    constexpr int n = 20000;
    for (std::uint64_t item = 0; item < n; ++item)
        for (const double u : random_unit(5, RandomStream::packing, item)) {
            ASSERT_GE(u, 0.0);
            ASSERT_LT(u, 1.0);
            sum += u;
            square += u * u;
            different.insert(u);
        }
    EXPECT_NEAR(sum / (4 * n), 0.5, 5.0 * std::sqrt(1.0 / 12.0 / (4 * n)));
    EXPECT_NEAR(square / (4 * n), 1.0 / 3.0, 5.0 * std::sqrt(4.0 / 45.0 / (4 * n)));
    EXPECT_GT(different.size(), 4u * n - 10u);
}

} // namespace
} // namespace talus::core
