// ranks: 1 2 3 4 6
// label: slow
// timeout: 3600
// The same as test_determinism.cpp over 20,000 steps. tools/compare-digests compares the digests printed here between compilers
// and optimisation levels.
#include "../support/determinism.hpp"

namespace talus::test {
namespace {

constexpr int64_t kSteps = 20000;

TEST(DeterminismOfLongRuns, shear_ends_with_the_bits_of_a_serial_run) { expect_same_bits(kShear, kSteps); }
TEST(DeterminismOfLongRuns, pouring_ends_with_the_bits_of_a_serial_run) { expect_same_bits(kPour, kSteps); }
TEST(DeterminismOfLongRuns, a_scene_periodic_in_two_axes_ends_with_the_bits_of_a_serial_run) { expect_same_bits(kPeriodic, kSteps); }

} // namespace
} // namespace talus::test
