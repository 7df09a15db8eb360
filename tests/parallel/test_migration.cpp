// ranks: 1 2 3 4 6 8
// timeout: 240
// Grains and their contacts wherever cuts lie: nothing is lost, nothing is invented, and the bits do not notice.
#include <algorithm>
#include <map>

#include "../support/determinism.hpp"
#include "capi/src/guard.hpp"
#include "runtime/phase/phases.hpp"

namespace talus::test {
namespace {

runtime::EngineState& inside(World& world) { return world.handle()->engine->state(); }

/// Rebuild lists and move cuts as the policy says, without touching a grain.
void force_rebuild(World& world) {
    int64_t removed = -1;
    world.check(talus_particles_remove_above(world.handle(), 1, 1e9, &removed));
    EXPECT_EQ(removed, 0);
}

/// Every grain's contacts, as they would travel: (label, partner) and the bits of the row. Over all ranks, on every rank.
using Histories = std::multimap<std::pair<int64_t, int64_t>, std::vector<double>>;
Histories histories_of(World& world) {
    runtime::EngineState& s = inside(world);
    core::ContactStore store;
    runtime::lay_out_contacts(s, store);
    std::vector<double> mine;
    const auto doubles = static_cast<std::size_t>(store.history_doubles);
    for (std::uint32_t g = 0; g < s.sub.n_owned; ++g)
        store.each(g, [&](core::Label partner, const core::HistoryPlace& place) {
            mine.push_back(std::bit_cast<double>(s.sub.particles[g].label));
            mine.push_back(std::bit_cast<double>(partner));
            mine.resize(mine.size() + doubles);
            store.get(place, mine.data() + mine.size() - doubles);
        });
    int n = static_cast<int>(mine.size()), ranks = world.ranks(), total = 0;
    std::vector<int> counts(static_cast<std::size_t>(ranks), n), first(static_cast<std::size_t>(ranks), 0);
    if (ranks > 1) MPI_Allgather(&n, 1, MPI_INT, counts.data(), 1, MPI_INT, MPI_COMM_WORLD);
    for (std::size_t r = 0; r < counts.size(); total += counts[r++]) first[r] = total;
    std::vector<double> all(static_cast<std::size_t>(total));
    if (ranks > 1)
        MPI_Allgatherv(mine.data(), n, MPI_DOUBLE, all.data(), counts.data(), first.data(), MPI_DOUBLE, MPI_COMM_WORLD);
    else
        all = mine;
    Histories h;
    const std::size_t item = 2 + doubles;
    for (std::size_t at = 0; at < all.size(); at += item)
        h.insert({{std::bit_cast<int64_t>(all[at]), std::bit_cast<int64_t>(all[at + 1])}, std::vector<double>(all.begin() + static_cast<std::ptrdiff_t>(at) + 2, all.begin() + static_cast<std::ptrdiff_t>(at + item))});
    return h;
}

HowToRun parallel_run(int32_t rebalance) {
    HowToRun run;
    run.comm = world_handle();
    run.threads = 2;
    run.rebalance = rebalance;
    run.tile_grains = 60;
    return run;
}

/// The state after `steps` of the same scene in a serial engine and over all ranks.
void expect_serial_bits(World (*make)(const HowToRun&), const HowToRun& run, int64_t steps) {
    const talus_state reference = serial_reference({"", make, plain_advance, false}, steps);
    World world = make(run);
    world.step(steps);
    EXPECT_EQ(digest_of(world.state()), digest_of(reference));
    EXPECT_EQ(world.state().particles, reference.particles);
}

TEST(Migration, contact_histories_survive_random_cuts_copy_by_copy) {
    for (const Scene& scene : {kShear, kPeriodic}) {
        SCOPED_TRACE(scene.name);
        World world = scene.make(parallel_run(TALUS_REBALANCE_RANDOM));
        world.step(120);
        const talus_state before = world.state();
        const Histories histories = histories_of(world);
        EXPECT_GT(before.sliding_contacts, 0);
        EXPECT_EQ(static_cast<int64_t>(histories.size()), 2 * before.contacts + before.wall_contacts) << "a pair has a copy at each of its grains";
        for (const auto& [who, row] : histories) {
            if (who.second >= core::kWallLabel) continue;
            EXPECT_EQ(histories.count(who), 1u);
            const auto mirror = histories.find({who.second, who.first});
            ASSERT_NE(mirror, histories.end());
            EXPECT_EQ(mirror->second, row) << "both grains of a pair carry the same row";
        }
        for (int times = 0; times < 4; ++times) {
            force_rebuild(world);
            const talus_state after = world.state();
            EXPECT_EQ(digest_of(after), digest_of(before));
            EXPECT_EQ(after.contacts, before.contacts);
            EXPECT_EQ(after.sliding_contacts, before.sliding_contacts);
            EXPECT_TRUE(histories_of(world) == histories);
        }
        if (world.ranks() > 1) {
            EXPECT_GT(world.state().migrations, before.migrations);
            EXPECT_GT(world.state().rebalances, before.rebalances);
        }
    }
}

TEST(Migration, no_policy_of_balance_shows_in_the_bits) {
    for (const Scene& scene : {kShear, kPour, kPeriodic}) {
        SCOPED_TRACE(scene.name);
        const talus_state reference = serial_reference(scene, 200);
        for (const int32_t policy : {TALUS_REBALANCE_OFF, TALUS_REBALANCE_AUTO, TALUS_REBALANCE_EVERY, TALUS_REBALANCE_RANDOM}) {
            World world = scene.make(parallel_run(policy));
            scene.advance(world, 0, 200, 200);
            const talus_state s = world.state();
            EXPECT_EQ(digest_of(s), digest_of(reference)) << "policy " << policy;
            EXPECT_GE(s.rebalances, world.ranks() > 1 && policy >= TALUS_REBALANCE_EVERY ? 2 : 0);
        }
    }
}

TEST(Migration, cuts_move_at_every_second_rebuild_if_told_so) {
    HowToRun run = parallel_run(TALUS_REBALANCE_RANDOM);
    run.rebalance_interval = 2;
    World world = make_periodic(run);
    world.step(20);
    for (int k = 0; k < 6; ++k) {
        const int64_t before = world.state().rebalances;
        force_rebuild(world);
        force_rebuild(world);
        EXPECT_EQ(world.state().rebalances - before, world.ranks() > 1 ? 1 : 0);
    }
}

TEST(Migration, ranks_without_any_grain_take_part_in_everything) {
    // Two grains that meet, over any number of ranks; cuts at random, so that ranks fill and empty.
    const auto make = [](const HowToRun& run) {
        talus_settings s = scene_settings({0, 0, 0}, {0.04, 0.04, 0.04}, run);
        for (double& g : s.gravity) g = 0.0;
        World world(s, run.comm);
        const int32_t sand = world.material(kSceneSand);
        world.contact(sand, sand, 0.5, 0.5, 0.1);
        world.wall(sand, {0, 0.0, 0}, {0, 1, 0});
        world.insert({{{0.019, 0.02, 0.02}, kSceneRadius, {2.0, 0.1, 0.0}, {50.0, 0.0, 100.0}}, {{0.0215, 0.0203, 0.02}, kSceneRadius, {-2.0, 0.0, -0.1}, {0.0, 30.0, 0.0}}}, 0.05);
        return world;
    };
    for (const int32_t rebalance : {TALUS_REBALANCE_OFF, TALUS_REBALANCE_EVERY, TALUS_REBALANCE_RANDOM}) expect_serial_bits(make, parallel_run(rebalance), 300);
    World world = make(parallel_run(TALUS_REBALANCE_OFF));
    world.step(10);
    int empty = world.state().local_particles == 0 ? 1 : 0, n_empty = 0;
    MPI_Allreduce(&empty, &n_empty, 1, MPI_INT, MPI_SUM, MPI_COMM_WORLD);
    EXPECT_GE(n_empty, world.ranks() - 2);
    int64_t count = -1;
    world.check(talus_particles_gather(world.handle(), TALUS_FIELD_LABEL, 0 + (world.rank() == 0 ? 2 : 0), std::vector<int64_t>(2).data(), &count));
    EXPECT_EQ(count, world.rank() == 0 ? 2 : 0);
}

TEST(Migration, grains_far_apart_and_far_from_each_others_ranks_meet_all_the_same) {
    // One fast grain crosses empty tiles and empty subdomains before it hits another: nothing but its own motion tells of it.
    const auto make = [](const HowToRun& run) {
        talus_settings s = scene_settings({0, 0, 0}, {0.12, 0.01, 0.01}, run);
        for (double& g : s.gravity) g = 0.0;
        if (run.comm != TALUS_SERIAL) s.rank_grid[0] = world_size();
        s.tile_grains = 1;
        World world(s, run.comm);
        const int32_t sand = world.material(kSceneSand);
        world.contact(sand, sand, 0.9, 0.5, 0.0);
        world.insert({{{0.004, 0.005, 0.005}, kSceneRadius, {20.0, 0.0, 0.0}, {}}, {{0.116, 0.0055, 0.005}, kSceneRadius, {}, {}}, {{0.116, 0.005, 0.0085}, kSceneRadius, {}, {}}}, 0.0);
        return world;
    };
    for (const int32_t rebalance : {TALUS_REBALANCE_OFF, TALUS_REBALANCE_RANDOM}) {
        World world = make(parallel_run(rebalance));
        world.step(560);
        double v[9] = {};
        int64_t count = 0;
        world.check(talus_particles_gather(world.handle(), TALUS_FIELD_VELOCITY, 3, v, &count));
        EXPECT_TRUE(world.rank() != 0 || v[3] > 5.0) << "the second grain was hit: " << v[3];
        expect_serial_bits(make, parallel_run(rebalance), 560);
    }
}

World make_chain(const HowToRun& run) {
    talus_settings s = scene_settings({0, 0, 0}, {0.03, 0.01, 0.01}, run);
    for (double& g : s.gravity) g = 0.0;
    if (run.comm != TALUS_SERIAL) s.rank_grid[0] = world_size();
    World world(s, run.comm);
    const int32_t sand = world.material(kSceneSand);
    world.contact(sand, sand, 0.3, 0.5, 0.05);
    std::vector<Grain> grains;
    for (int k = 0; k < 6; ++k) {
        const double x = 0.004 + 1.97 * kSceneRadius * k;
        grains.push_back({{x, 0.005 + (k % 2) * 1e-4, 0.005}, kSceneRadius, {0.4 - 0.2 * k, k % 2 ? 0.3 : -0.3, 0.0}, {0.0, 20.0, 100.0 * k}});
    }
    world.insert(grains, 0.1);
    return world;
}

TEST(Migration, a_grain_whose_contacts_lie_on_two_other_ranks_keeps_its_bits) {
    for (const int32_t rebalance : {TALUS_REBALANCE_OFF, TALUS_REBALANCE_EVERY, TALUS_REBALANCE_RANDOM}) expect_serial_bits(make_chain, parallel_run(rebalance), 250);
    World world = make_chain(parallel_run(TALUS_REBALANCE_OFF));
    world.step(1);
    const talus_state s = world.state();
    EXPECT_EQ(s.contacts, 5);
    int64_t mine = s.local_particles, most = 0;
    MPI_Allreduce(&mine, &most, 1, MPI_INT64_T, MPI_MAX, MPI_COMM_WORLD);
    EXPECT_EQ(most, (6 + world.ranks() - 1) / world.ranks()) << "balanced cuts share the chain out";
}

TEST(Migration, a_periodic_axis_may_be_cut_in_any_number_of_subdomains_along_each_axis) {
    for (int axis = 0; axis < 3; ++axis) {
        HowToRun run = parallel_run(TALUS_REBALANCE_OFF);
        run.rank_grid[axis] = world_size();
        for (const int32_t rebalance : {TALUS_REBALANCE_OFF, TALUS_REBALANCE_RANDOM}) {
            run.rebalance = rebalance;
            expect_serial_bits(make_gas, run, 120);
        }
    }
}

TEST(Migration, subdomains_may_be_narrower_than_a_grain) {
    const talus_state reference = serial_reference(kPeriodic, 60);
    World world = make_periodic([] {
        HowToRun run = parallel_run(TALUS_REBALANCE_OFF);
        run.rank_grid[0] = world_size();
        return run;
    }());
    world.step(20);
    // Cuts a fifth of a radius apart, in the middle of the bed.
    auto& cuts = inside(world).slices.cuts(0);
    for (std::size_t k = 0; k < cuts.size(); ++k) cuts[k] = 0.02 + 0.2 * kSceneRadius * static_cast<double>(k);
    force_rebuild(world);
    world.step(40);
    EXPECT_EQ(digest_of(world.state()), digest_of(reference));
}

TEST(Migration, grains_exactly_on_a_cut_belong_to_one_rank_and_keep_their_bits) {
    const talus_state reference = serial_reference(kGas, 60);
    for (int axis = 0; axis < 3; ++axis) {
        HowToRun run = parallel_run(TALUS_REBALANCE_OFF);
        run.rank_grid[axis] = world_size();
        World world = make_gas(run);
        world.step(0);
        // The lattice stands at multiples of an eighth of the box: cuts there hit a plane of 64 grains each, corners included.
        auto& cuts = inside(world).slices.cuts(axis);
        for (std::size_t k = 0; k < cuts.size(); ++k) cuts[k] = 12.0 * 2.0 * kSceneRadius / 8.0 * static_cast<double>(k == 0 ? 0 : k + 1);
        force_rebuild(world);
        const talus_state s = world.state();
        EXPECT_EQ(s.particles, 512);
        int64_t mine = s.local_particles, total = 0;
        MPI_Allreduce(&mine, &total, 1, MPI_INT64_T, MPI_SUM, MPI_COMM_WORLD);
        EXPECT_EQ(total, 512);
        world.step(60);
        EXPECT_EQ(digest_of(world.state()), digest_of(reference));
    }
}

TEST(Migration, a_period_just_above_twice_the_reach_may_be_cut_in_two) {
    const auto make = [](const HowToRun& run) {
        const double reach = 2.0 * kSceneRadius * 1.1;
        talus_settings s = scene_settings({0, 0, 0}, {2.001 * reach, 2.001 * reach, 2.001 * reach}, run);
        for (int a = 0; a < 3; ++a) {
            s.periodic[a] = 1;
            s.gravity[a] = 0.0;
        }
        World world(s, run.comm);
        const int32_t sand = world.material(kSceneSand);
        world.contact(sand, sand, 0.8, 0.5, 0.05);
        std::vector<Grain> grains;
        Random random(2);
        for (int k = 0; k < 8; ++k) grains.push_back({{reach * (k & 1), reach * (k >> 1 & 1), reach * (k >> 2)}, kSceneRadius, random.vector(3.0), random.vector(500.0)});
        world.insert(grains, 0.0);
        return world;
    };
    HowToRun run = parallel_run(TALUS_REBALANCE_OFF);
    for (int axis = 0, left = world_size(); left % 2 == 0; left /= 2) run.rank_grid[axis++] = 2;
    if (world_size() == 3 || world_size() == 6) return; // a third of the period is narrower than the halo
    for (const int32_t rebalance : {TALUS_REBALANCE_OFF, TALUS_REBALANCE_RANDOM}) {
        run.rebalance = rebalance;
        expect_serial_bits(make, run, 600);
    }
}

TEST(Migration, displacements_and_sums_travel_with_the_grains) {
    const auto fields = [](World& world) {
        std::vector<double> all;
        for (const int32_t field : {TALUS_FIELD_DISPLACEMENT, TALUS_FIELD_FORCE, TALUS_FIELD_TORQUE}) {
            std::vector<double> v(3 * 2240);
            int64_t count = 0;
            world.check(talus_particles_gather(world.handle(), field, 2240, v.data(), &count));
            all.insert(all.end(), v.begin(), v.end());
        }
        return all;
    };
    std::vector<double> reference;
    if (world_rank_of_me() == 0) {
        World serial = make_periodic(HowToRun{});
        serial.step(150);
        reference = fields(serial);
    }
    World world = make_periodic(parallel_run(TALUS_REBALANCE_RANDOM));
    world.step(150);
    const auto found = fields(world);
    EXPECT_TRUE(world.rank() != 0 || found == reference);
    EXPECT_GT(world.ranks() == 1 ? 1 : world.state().migrations, 0);
}

} // namespace
} // namespace talus::test
