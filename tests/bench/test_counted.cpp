// Operations counted by running laws and kernels on a number that counts: right where they can be counted by hand, and the kernel
// that counts is the kernel that is measured.
#include <gtest/gtest.h>

#include "apps/bench/flops.hpp"
#include "apps/bench/laws.hpp"
#include "apps/bench/lists.hpp"
#include "apps/bench/scene.hpp"
#include "runtime/phase/phases.hpp"
#include "tests/support/kernel_bench.hpp"

namespace {

using namespace talus;
using bench::Operations;

void expect_same(const Operations& counted, const Operations& expected, const std::string& what) {
    EXPECT_EQ(counted.add, expected.add) << what;
    EXPECT_EQ(counted.multiply, expected.multiply) << what;
    EXPECT_EQ(counted.fused, expected.fused) << what;
    EXPECT_EQ(counted.divide, expected.divide) << what;
    EXPECT_EQ(counted.root, expected.root) << what;
}

core::Laws linear_frictionless() {
    core::Laws l;
    l.normal = core::NormalLaw::linear;
    l.tangential = core::TangentialLaw::none;
    l.rolling = core::RollingLaw::none;
    return l;
}

TEST(Counted, flops_take_a_fused_operation_as_two) { EXPECT_EQ((Operations{1, 2, 3, 4, 5, 6}.flops()), 1 + 2 + 6 + 4 + 5); }

TEST(Counted, a_linear_contact_without_friction_costs_what_a_hand_counts) {
    const bench::LawOperations law = bench::count_law(linear_frictionless());
    // x - y; its image: to periods, rounded by adding and taking away, back; its square against that of the radii's sum.
    expect_same(law.candidate, {3 + 2 * 3 + 1, 3 + 1 + 1, 3 + 2, 0, 0}, "candidate");
    ASSERT_EQ(law.parts.size(), 5u);
    const auto& normal = law.parts.back();
    EXPECT_EQ(normal.name, "normal");
    // sqrt(m); k d; c sqrt(m), of both directions; elastic - damping v as one; force = total n.
    expect_same(normal.operations, {0, 1 + 2 + 3, 1, 0, 1}, "normal");
}

TEST(Counted, every_part_of_every_law_has_a_name) {
    for (const core::Laws& laws : test::all_laws())
        for (const auto& part : bench::count_law(laws).parts) EXPECT_FALSE(part.name.empty()) << test::name_of(laws);
}

/// The sums of all tiles.
std::vector<std::int64_t> sums_of(const runtime::EngineState& s) {
    std::vector<std::int64_t> all;
    for (const core::Tile& tile : s.sub.tiles)
        for (const std::int64_t n : test::numbers(tile.sums)) all.push_back(n);
    return all;
}

/// The same evaluation by a kernel of the library.
void evaluate(runtime::EngineState& s) {
    runtime::refresh_contexts(s);
    s.kernels = core::select_kernels(s.model.settings.laws, false, core::KernelWidth::scalar);
    s.force.advance = false;
    s.with_forces = true;
    s.workers.arena().execute([&] {
        for (int t = 0; t < static_cast<int>(s.sub.tiles.size()); ++t) runtime::force_tile(s, t);
    });
    for (core::Tile& tile : s.sub.tiles) core::collect_border(s.sub.tiles, tile);
}

TEST(Counted, the_kernel_that_counts_gives_the_same_sums) {
    bench::SceneOptions options;
    options.grains = 300;
    for (const char* name : {"default_spring", "displacement_attractive", "linear"}) {
        const auto* laws = std::find_if(std::begin(bench::kLaws), std::end(bench::kLaws), [&](const bench::NamedLaws& l) { return l.name == std::string(name); });
        const bench::Scene scene = bench::make_bed(options, laws->laws());
        runtime::EngineState& s = scene.engine->engine->state();
        const bench::ForceOperations counted = bench::count_forces(s);
        const std::vector<std::int64_t> sums = sums_of(s);
        evaluate(s);
        EXPECT_TRUE(sums == sums_of(s)) << name;

        const bench::ListCounts pairs = bench::count_pairs(s), walls = bench::count_walls(s);
        ASSERT_GT(pairs.contacts, 100.0) << name;
        ASSERT_GT(walls.contacts, 10.0) << name;
        // Divisions and roots are the law's and the geometry's alone, of a contact that has parted those of the overlap.
        const bench::LawOperations law = bench::count_law(s.model.settings.laws);
        const Operations contact = law.contact(), overlap = law.parts.front().operations;
        const double parted = pairs.standing() - pairs.contacts;
        EXPECT_EQ(counted.pairs.divide, pairs.contacts * contact.divide + parted * overlap.divide) << name;
        EXPECT_EQ(counted.pairs.root, pairs.contacts * contact.root + parted * overlap.root) << name;
        EXPECT_GE(counted.pairs.fused, pairs.contacts * contact.fused) << name;
        EXPECT_GT(counted.walls.root, 0.0) << name;
    }
}

} // namespace
