// label: slow
// Many calls of one step beside one call of many: driving an engine through the ABI must cost nothing.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdio>

#include "../support/sheared_block.hpp"

namespace talus::test {
namespace {

constexpr int kSteps = 1000, kWindow = 20;

double seconds_of(World& world, bool one_by_one) {
    const auto from = std::chrono::steady_clock::now();
    if (one_by_one)
        for (int k = 0; k < kWindow; ++k) world.step(1);
    else
        world.step(kWindow);
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - from).count();
}

TEST(StepCalls, a_thousand_calls_take_as_long_as_one_and_end_with_the_same_bits) {
    HowToRun run;
    run.tile_grains = 0;
    World whole = make_sheared_block({40, 32, 40}, 0.1, run), single = make_sheared_block({40, 32, 40}, 0.1, run);
    std::vector<double> ratio;
    for (int k = 0; k < kSteps / kWindow; ++k) { // in turn, the other first in every second round, since the machine's speed changes
        double a = 0.0, b = 0.0;
        for (const bool one_by_one : {k % 2 == 0, k % 2 != 0}) (one_by_one ? a : b) = seconds_of(one_by_one ? single : whole, one_by_one);
        ratio.push_back(a / b);
    }
    std::sort(ratio.begin(), ratio.end());
    std::printf("%d calls of one step: %.4f of the time of calls of %d (quartiles %.4f and %.4f)\n", kSteps, ratio[ratio.size() / 2], kWindow, ratio[ratio.size() / 4], ratio[3 * ratio.size() / 4]);
    EXPECT_LT(ratio[ratio.size() / 2], 1.02);
    const talus_state a = single.state(), b = whole.state();
    EXPECT_EQ(a.digest_lo, b.digest_lo);
    EXPECT_EQ(a.digest_hi, b.digest_hi);
}

} // namespace
} // namespace talus::test
