// ranks: 1 2 3 4 6
// timeout: 240
// The trajectory is a function of the physics alone: the same bits on any ranks and threads, with any skin, tiles and cuts.
#include "../support/determinism.hpp"

namespace talus::test {
namespace {

TEST(Determinism, shear_ends_with_the_bits_of_a_serial_run_on_any_ranks_threads_skin_and_cuts) { expect_same_bits(kShear, 400); }
TEST(Determinism, pouring_ends_with_the_bits_of_a_serial_run_on_any_ranks_threads_skin_and_cuts) { expect_same_bits(kPour, 400); }
TEST(Determinism, a_scene_periodic_in_two_axes_ends_with_the_bits_of_a_serial_run_on_any_ranks_threads_skin_and_cuts) { expect_same_bits(kPeriodic, 400); }

} // namespace
} // namespace talus::test
