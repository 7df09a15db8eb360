// Settings: every fault is named, all at once, with the value seen.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "runtime/settings.hpp"

namespace talus::runtime {
namespace {

Settings good() {
    Settings s;
    for (double& h : s.domain.hi) h = 1.0;
    s.time_step = 1e-6;
    return s;
}
std::string faults(const std::function<void(Settings&)>& spoil, int ranks = 1) {
    Settings s = good();
    spoil(s);
    return settings_faults(s, ranks);
}
int lines(const std::string& text) { return text.empty() ? 0 : 1 + static_cast<int>(std::count(text.begin(), text.end(), '\n')); }

TEST(Settings, that_are_fine_have_no_fault) {
    for (const int ranks : {1, 2, 3, 7, 64}) EXPECT_EQ(settings_faults(good(), ranks), "");
}

TEST(Settings, each_fault_is_one_line_that_names_the_key_and_the_value) {
    const struct {
        std::function<void(Settings&)> spoil;
        const char *key, *value;
    } cases[] = {
        {[](Settings& s) { s.domain.hi[1] = NAN; }, "domain_lo/hi y", "nan"},
        {[](Settings& s) { s.domain.lo[2] = 3.5; }, "domain_lo/hi z", "3.5"},
        {[](Settings& s) { s.domain.lo[0] = 1.0; }, "domain_lo/hi x", "1"},
        {[](Settings& s) { s.gravity[1] = HUGE_VAL; }, "gravity y", "inf"},
        {[](Settings& s) { s.threads = 0; }, "threads", "0"},
        {[](Settings& s) { s.threads = -3; }, "threads", "-3"},
        {[](Settings& s) { s.threads = 100000; }, "threads", "100000"},
        {[](Settings& s) { s.time_step = 0.0; }, "time_step", "0"},
        {[](Settings& s) { s.time_step = -1e-6; }, "time_step", "-1e-06"},
        {[](Settings& s) { s.time_step = NAN; }, "time_step", "nan"},
        {[](Settings& s) { s.time_step_limit = 1.5; }, "time_step_limit", "1.5"},
        {[](Settings& s) { s.skin = -0.1; }, "skin", "-0.1"},
        {[](Settings& s) { s.skin = HUGE_VAL; }, "skin", "inf"},
        {[](Settings& s) { s.radius_max = -2.0; }, "radius_max", "-2"},
        {[](Settings& s) { s.tile_grains = -7; }, "tile_grains", "-7"},
        {[](Settings& s) { s.rebalance = static_cast<Rebalance>(9); }, "rebalance", "9"},
        {[](Settings& s) { s.rank_grid[1] = -2; }, "rank_grid y", "-2"},
        {[](Settings& s) { s.rank_grid = {2, 1, 1}; }, "rank_grid", "2 1 1"},
        {[](Settings& s) { s.laws.normal = static_cast<core::NormalLaw>(7); }, "laws.normal", "7"},
        {[](Settings& s) { s.laws.tangential = static_cast<core::TangentialLaw>(-1); }, "laws.tangential", "-1"},
        {[](Settings& s) { s.laws.normal = core::NormalLaw::linear; }, "laws", "stiffness_n"},
        {[](Settings& s) { s.laws.rolling_rate = 0.0; }, "laws", "rolling_rate"},
        {[](Settings& s) { s.laws.rolling = core::RollingLaw::spring; s.laws.rolling_damping = -1.0; }, "laws", "rolling_damping"},
        {[](Settings& s) { s.laws.rolling = core::RollingLaw::spring; s.laws.rolling_radius = core::RollingRadius::own; }, "laws", "rolling_radius OWN"},
    };
    for (const auto& c : cases) {
        const std::string text = faults(c.spoil);
        EXPECT_EQ(lines(text), 1) << text;
        EXPECT_NE(text.find(c.key), std::string::npos) << text;
        EXPECT_NE(text.find(c.value), std::string::npos) << text;
    }
}

TEST(Settings, all_faults_are_listed_at_once) {
    const std::string text = faults([](Settings& s) {
        s.domain.hi[0] = NAN;
        s.domain.lo[1] = 2.0;
        s.gravity[2] = NAN;
        s.threads = 0;
        s.time_step = -1.0;
        s.time_step_limit = 0.0;
        s.skin = NAN;
        s.radius_max = NAN;
        s.tile_grains = -1;
        s.rebalance = static_cast<Rebalance>(-1);
        s.rank_grid[0] = -1;
        s.laws.damping = static_cast<core::Damping>(5);
        s.laws.rolling = static_cast<core::RollingLaw>(5);
    });
    EXPECT_EQ(lines(text), 13) << text;
}

TEST(Settings, a_rank_grid_must_multiply_to_the_number_of_ranks) {
    const auto grid = [](std::array<int, 3> g) { return [g](Settings& s) { s.rank_grid = g; }; };
    EXPECT_EQ(faults(grid({2, 0, 3}), 12), "");
    EXPECT_EQ(faults(grid({0, 0, 0}), 12), "");
    EXPECT_EQ(lines(faults(grid({2, 2, 2}), 12)), 1);
    EXPECT_EQ(lines(faults(grid({5, 0, 0}), 12)), 1);
    EXPECT_NE(faults(grid({5, 0, 0}), 12).find("12"), std::string::npos);
}

TEST(Settings, of_laws_are_refused_before_any_kernel_is_chosen_for_them) {
    core::Laws l;
    EXPECT_EQ(laws_faults(l), "");
    l.rolling_radius = static_cast<core::RollingRadius>(2);
    l.normal = static_cast<core::NormalLaw>(2);
    EXPECT_EQ(lines(laws_faults(l)), 2);
}

} // namespace
} // namespace talus::runtime
