// The scenes of talus-bench, small: the chute flows and stays on its incline, the gas collides and cools and makes lists short-lived, and
// what is written for other codes is what stands in the engine.
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <sstream>

#include "apps/bench/grains.hpp"
#include "apps/bench/lists.hpp"
#include "apps/bench/scene.hpp"
#include "apps/bench/table.hpp"

namespace {

using namespace talus::bench;

SceneOptions small(std::int64_t grains) {
    SceneOptions o;
    o.grains = grains;
    return o;
}

double kinetic_energy(talus_engine* engine) {
    talus_energy e;
    check(talus_energy_init(&e), engine);
    check(talus_engine_energy(engine, &e), engine);
    return e.kinetic;
}

TEST(Scenes, the_chute_flows_down_its_incline_at_a_steady_speed) {
    const Scene scene = make_chute(small(600));
    talus_engine* engine = scene.engine.get();
    const auto before = mean_velocity(gather(engine));
    check(talus_engine_step(engine, 10000, nullptr), engine);
    const auto after = mean_velocity(gather(engine));
    // Bagnold's profile of 25 diameters at this angle has a mean of 7 to 8 sqrt(g d); without friction it would gain 0.41 in these steps.
    EXPECT_GT(before[0], 4.0 * chute_speed());
    EXPECT_LT(before[0], 12.0 * chute_speed());
    EXPECT_LT(std::abs(after[0] - before[0]), 0.2 * chute_speed());
    EXPECT_LT(std::abs(after[1]), 0.3 * chute_speed());
    EXPECT_LT(std::abs(after[2]), 0.5 * chute_speed());
    EXPECT_GT(count_pairs(engine->engine->state()).contacts, 100.0);
}

TEST(Scenes, frozen_grains_carry_the_chute_and_are_not_counted_in_its_speed) {
    const Scene scene = make_chute(small(600));
    const Grains grains = gather(scene.engine.get());
    std::size_t frozen = 0;
    for (std::size_t k = 0; k < grains.count(); ++k) {
        if (grains.group[k] != kFrozen) continue;
        ++frozen;
        for (std::size_t a = 0; a < 3; ++a) EXPECT_EQ(grains.velocity[3 * k + a], 0.0);
    }
    EXPECT_GT(frozen, 10u);
    EXPECT_LT(frozen, grains.count() / 10);
}

TEST(Scenes, the_gas_collides_and_cools_and_needs_a_rebuild_every_few_steps) {
    SceneOptions options = small(2000);
    options.skin = 0.25e-3; // pinned: rebuilds are counted
    const Scene scene = make_gas(options);
    talus_engine* engine = scene.engine.get();
    check(talus_engine_step(engine, 0, nullptr), engine);
    const auto& s = engine->engine->state();
    EXPECT_EQ(count_pairs(s).contacts, 0.0);
    const double before = kinetic_energy(engine);
    const std::int64_t rebuilds = s.counters.rebuilds;
    check(talus_engine_step(engine, 100, nullptr), engine);
    EXPECT_GT(count_pairs(s).contacts, 0.05 * s.sub.n_owned);
    EXPECT_LT(kinetic_energy(engine), 0.9 * before);
    EXPECT_GE(s.counters.rebuilds - rebuilds, 10);
    EXPECT_LE(s.counters.rebuilds - rebuilds, 50);
}

TEST(Scenes, a_written_bed_holds_the_grains_with_the_axes_changed) {
    const Scene scene = make_gas(small(125));
    const Grains grains = gather(scene.engine.get());
    const std::string path = testing::TempDir() + "bench_bed.txt";
    write_bed(path, "xzy", scene.lo, scene.hi, grains);
    std::ifstream file(path);
    std::string hash;
    std::size_t n = 0;
    double box[6];
    file >> hash >> n;
    for (double& b : box) file >> b;
    EXPECT_EQ(hash, "#");
    ASSERT_EQ(n, grains.count());
    EXPECT_EQ(box[5], scene.hi[1]); // up is the file's z
    EXPECT_EQ(box[3], scene.hi[2]);
    for (std::size_t k = 0; k < n; ++k) {
        std::int64_t label = -1;
        double x[3], radius, v[3];
        file >> label >> x[0] >> x[1] >> x[2] >> radius >> v[0] >> v[1] >> v[2];
        ASSERT_TRUE(file) << "grain " << k;
        EXPECT_EQ(label, grains.label[k]);
        EXPECT_EQ(radius, grains.radius[k]);
        constexpr std::size_t kOurs[] = {0, 2, 1};
        for (std::size_t a = 0; a < 3; ++a) {
            EXPECT_EQ(x[a], grains.position[3 * k + kOurs[a]]);
            EXPECT_EQ(v[a], grains.velocity[3 * k + kOurs[a]]);
        }
    }
    std::remove(path.c_str());
    EXPECT_THROW(write_bed(testing::TempDir() + "no/such/folder", "xyz", scene.lo, scene.hi, grains), talus::core::Error);
}

} // namespace
