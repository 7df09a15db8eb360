// The C ABI at work: views and copies, generations, phases, stops, laws, removal, colours, groups.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <functional>
#include <thread>

#include "../support/small_world.hpp"

namespace talus::test {
namespace {

TEST(Api, views_copies_and_gathers_of_a_field_agree) {
    World world = small_world();
    world.step(20);
    constexpr int64_t n = 72;
    std::vector<int64_t> labels(n);
    int64_t count = 0;
    world.check(talus_particles_copy(world.handle(), TALUS_FIELD_LABEL, n, labels.data(), &count));
    EXPECT_EQ(count, n);
    for (int64_t k = 0; k < n; ++k) EXPECT_EQ(labels[static_cast<std::size_t>(k)], k) << "ordered by label";
    for (const int32_t field : {TALUS_FIELD_POSITION, TALUS_FIELD_RADIUS, TALUS_FIELD_VELOCITY, TALUS_FIELD_ANGULAR_VELOCITY, TALUS_FIELD_MASS}) {
        talus_view view{};
        view.struct_size = sizeof view;
        world.check(talus_particles_view(world.handle(), field, &view));
        ASSERT_EQ(view.count, n);
        const auto width = static_cast<std::size_t>(view.components);
        std::vector<double> copy(n * width), gathered(n * width);
        world.check(talus_particles_copy(world.handle(), field, n, copy.data(), &count));
        world.check(talus_particles_gather(world.handle(), field, n, gathered.data(), &count));
        EXPECT_EQ(copy, gathered);
        std::vector<std::vector<double>> seen, rows;
        for (int64_t k = 0; k < n; ++k) {
            const auto* at = reinterpret_cast<const double*>(reinterpret_cast<const char*>(view.data) + k * view.stride);
            seen.emplace_back(at, at + width);
            rows.emplace_back(copy.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(k) * width), copy.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(k + 1) * width));
        }
        std::sort(seen.begin(), seen.end());
        std::sort(rows.begin(), rows.end());
        EXPECT_EQ(seen, rows) << "field " << field;
    }
    talus_view view{};
    view.struct_size = sizeof view;
    for (const int32_t field : {TALUS_FIELD_LABEL, TALUS_FIELD_FORCE, TALUS_FIELD_COLOUR, 99, -1}) EXPECT_EQ(talus_particles_view(world.handle(), field, &view), TALUS_ERR_ARGUMENT) << field;
    count = -1;
    EXPECT_EQ(talus_particles_copy(world.handle(), TALUS_FIELD_RADIUS, n - 1, labels.data(), &count), TALUS_ERR_ARGUMENT);
    EXPECT_EQ(count, n) << "the capacity that is needed";
}

TEST(Api, whatever_changes_grains_makes_views_stale_and_what_only_looks_does_not) {
    World world = small_world();
    world.step(2);
    uint64_t before = 0, after = 0;
    const auto generation = [&] {
        uint64_t g = 0;
        world.check(talus_engine_generation(world.handle(), &g));
        return g;
    };
    before = generation();
    world.state();
    talus_energy energy;
    talus_energy_init(&energy);
    world.check(talus_engine_energy(world.handle(), &energy));
    int64_t sum[3];
    world.check(talus_engine_internal_force_sum(world.handle(), sum, nullptr));
    EXPECT_EQ(generation(), before);
    const double v[3] = {0.1, 0, 0};
    const std::pair<const char*, std::function<void()>> changes[] = {
        {"step", [&] { world.step(1); }},
        {"add_velocity", [&] { world.check(talus_particles_add_velocity(world.handle(), v)); }},
        {"stop", [&] { world.check(talus_particles_stop(world.handle())); }},
        {"insert", [&] { world.insert({{{0.006, 0.012, 0.006}, kSceneRadius, {}, {}}}, 0.01, 500); }},
        {"remove", [&] { world.check(talus_particles_remove_above(world.handle(), 1, 0.01, nullptr)); }},
        {"colour", [&] { world.check(talus_particles_colour_layers(world.handle(), 1, 0.0, 0.002)); }},
    };
    for (const auto& [name, change] : changes) {
        before = generation();
        change();
        after = generation();
        EXPECT_NE(before, after) << name;
    }
}

TEST(Api, phases_are_named_counted_and_fit_or_tell_how_many_there_are) {
    World world = small_world();
    world.step(10);
    talus_phase phases[16];
    int32_t n = 2;
    phases[0].struct_size = 0;
    EXPECT_EQ(talus_engine_phases(world.handle(), &n, phases), TALUS_ERR_ARGUMENT);
    talus_phase_init(phases);
    EXPECT_EQ(talus_engine_phases(world.handle(), &n, phases), TALUS_ERR_ARGUMENT);
    EXPECT_EQ(n, 7);
    n = 16;
    world.check(talus_engine_phases(world.handle(), &n, phases));
    const char* names[] = {"binning", "pair_build", "force", "integrate", "halo_exchange", "rebalance", "observe"};
    ASSERT_EQ(n, 7);
    for (int k = 0; k < 7; ++k) {
        EXPECT_STREQ(phases[k].name, names[k]);
        EXPECT_LE(phases[k].min, phases[k].max);
        EXPECT_EQ(phases[k].struct_size, sizeof(talus_phase));
    }
    EXPECT_GE(phases[2].calls, 10);
    EXPECT_GT(phases[2].max, 0.0);

    // Items of a program with a later header, and with an earlier one.
    for (const std::size_t size : {sizeof(talus_phase) + 24, sizeof(talus_phase) - 8}) {
        std::vector<unsigned char> bytes(7 * size + 8, 0xee);
        std::uint32_t first = static_cast<std::uint32_t>(size);
        std::memcpy(bytes.data(), &first, sizeof first);
        world.check(talus_engine_phases(world.handle(), &n, reinterpret_cast<talus_phase*>(bytes.data())));
        for (std::size_t k = 0; k < 7; ++k) {
            EXPECT_STREQ(reinterpret_cast<const char*>(bytes.data() + k * size + offsetof(talus_phase, name)), names[k]);
            for (std::size_t b = sizeof(talus_phase); b < size; ++b) EXPECT_EQ(bytes[k * size + b], 0xee);
        }
        for (std::size_t b = 7 * size; b < bytes.size(); ++b) EXPECT_EQ(bytes[b], 0xee);
    }
}

TEST(Api, a_requested_stop_is_honoured_once_between_steps_and_leaves_the_engine_whole) {
    World world = small_world(), undisturbed = small_world();
    world.step(3);
    talus_engine_request_stop(world.handle());
    int64_t done = -1;
    EXPECT_EQ(talus_engine_step(world.handle(), 50, &done), TALUS_STOPPED);
    EXPECT_GE(done, 1);
    EXPECT_LT(done, 5);
    EXPECT_EQ(world.state().step, 3 + done);
    world.step(50 - done);
    undisturbed.step(53);
    EXPECT_EQ(digest(world), digest(undisturbed));

    // From another thread, which may come late: a scene that can go on for long.
    World lasting = make_shear(HowToRun{});
    std::thread other([&] { talus_engine_request_stop(lasting.handle()); });
    const talus_status status = talus_engine_step(lasting.handle(), 1000000, &done);
    other.join();
    EXPECT_EQ(status, TALUS_STOPPED);
}

TEST(Api, laws_changed_between_steps_start_all_histories_anew_but_keep_the_contacts) {
    World world = make_shear(HowToRun{});
    world.step(40);
    EXPECT_GT(world.state().contacts, 1000);
    talus_energy energy;
    talus_energy_init(&energy);
    world.check(talus_engine_energy(world.handle(), &energy));
    EXPECT_GT(energy.elastic_tangential, 0.0);
    talus_laws laws;
    talus_laws_init(&laws);
    world.check(talus_engine_set_laws(world.handle(), &laws));
    world.check(talus_engine_energy(world.handle(), &energy));
    EXPECT_GT(energy.elastic_tangential, 0.0) << "the same laws again change nothing";
    for (const int32_t tangential : {TALUS_TANGENTIAL_DISPLACEMENT, TALUS_TANGENTIAL_NONE, TALUS_TANGENTIAL_FORCE})
        for (const int32_t rolling : {TALUS_ROLLING_SPRING, TALUS_ROLLING_NONE}) {
            laws.tangential = tangential;
            laws.rolling = rolling;
            world.check(talus_engine_set_laws(world.handle(), &laws));
            world.check(talus_engine_energy(world.handle(), &energy));
            EXPECT_EQ(energy.elastic_tangential, 0.0);
            EXPECT_EQ(energy.elastic_rolling, 0.0);
            world.step(20);
            world.check(talus_engine_energy(world.handle(), &energy));
            EXPECT_EQ(energy.elastic_tangential > 0.0, tangential != TALUS_TANGENTIAL_NONE);
            EXPECT_EQ(energy.elastic_rolling > 0.0, rolling == TALUS_ROLLING_SPRING);
        }
    laws.normal = TALUS_NORMAL_LINEAR;
    laws.stiffness_n = 1000.0;
    EXPECT_EQ(talus_engine_set_laws(world.handle(), &laws), TALUS_ERR_STATE) << "the unit of sums follows from the normal law";
    laws.normal = 5;
    EXPECT_EQ(talus_engine_set_laws(world.handle(), &laws), TALUS_ERR_ARGUMENT);
}

TEST(Api, a_linear_law_may_be_softened_and_stiffened_again_as_far_as_the_first_steps_unit_reaches) {
    talus_settings settings = bare_settings({0, 0, 0}, {1, 1, 1}, 1e-5);
    settings.laws.normal = TALUS_NORMAL_LINEAR;
    settings.laws.stiffness_n = 1000.0;
    talus_engine* raw = nullptr;
    ASSERT_EQ(talus_engine_create(&settings, &raw), TALUS_OK);
    World world(raw);
    talus_material material;
    talus_material_init(&material);
    material.young = 1e7;
    material.poisson = 0.2;
    material.density = 2500.0;
    int32_t first = 0;
    world.check(talus_material_add(raw, &material, &first));
    const double position[3] = {0.5, 0.5, 0.5}, radius = 0.01;
    talus_particles grain;
    talus_particles_init(&grain);
    talus_contact contact;
    talus_contact_init(&contact);
    contact.restitution = 0.5;
    contact.friction = 0.5;
    world.check(talus_contact_set(raw, first, first, &contact));
    const int64_t label = 1;
    grain.count = 1;
    grain.label = &label;
    grain.position = position;
    grain.radius = &radius;
    world.check(talus_particles_insert(raw, &grain, 0.0));
    world.step(1);
    talus_laws laws = settings.laws;
    for (const double stiffness : {100.0, 1000.0}) {
        laws.stiffness_n = stiffness;
        EXPECT_EQ(talus_engine_set_laws(raw, &laws), TALUS_OK) << talus_engine_message(raw);
    }
    laws.stiffness_n = 2001.0; // units are powers of two: below twice the first there may be room
    EXPECT_EQ(talus_engine_set_laws(raw, &laws), TALUS_ERR_STATE);
    EXPECT_NE(std::string(talus_engine_message(raw)).find("has room for at most"), std::string::npos) << talus_engine_message(raw);
}

TEST(Api, grains_above_a_level_are_removed_and_the_others_stay) {
    World world = small_world();
    world.step(5);
    int64_t removed = -1, count = 0;
    EXPECT_EQ(talus_particles_remove_above(world.handle(), 3, 0.0, &removed), TALUS_ERR_ARGUMENT);
    world.check(talus_particles_remove_above(world.handle(), 1, 0.002, &removed));
    EXPECT_EQ(removed, 36);
    EXPECT_EQ(world.state().particles, 36);
    std::vector<double> x(3 * 36);
    world.check(talus_particles_copy(world.handle(), TALUS_FIELD_POSITION, 36, x.data(), &count));
    for (std::size_t k = 0; k < 36; ++k) EXPECT_LE(x[3 * k + 1], 0.002);
    world.step(20);
    world.check(talus_particles_remove_above(world.handle(), 1, 1.0, &removed));
    EXPECT_EQ(removed, 0);
    world.check(talus_particles_remove_above(world.handle(), 1, -1.0, &removed));
    EXPECT_EQ(removed, 36);
    EXPECT_EQ(world.state().particles, 0);
    EXPECT_EQ(talus_engine_step(world.handle(), 1, nullptr), TALUS_ERR_STATE);
}

TEST(Api, colours_count_layers_modulo_256_below_the_origin_too) {
    World world = small_world();
    std::vector<int32_t> colour(72);
    std::vector<double> x(3 * 72);
    int64_t count = 0;
    for (const double thickness : {0.0015, 0.00001})
        for (const double origin : {0.0, 0.05}) {
            world.check(talus_particles_colour_layers(world.handle(), 1, origin, thickness));
            world.check(talus_particles_copy(world.handle(), TALUS_FIELD_COLOUR, 72, colour.data(), &count));
            world.check(talus_particles_copy(world.handle(), TALUS_FIELD_POSITION, 72, x.data(), &count));
            for (std::size_t k = 0; k < 72; ++k) {
                const auto layer = static_cast<int64_t>(std::floor((x[3 * k + 1] - origin) / thickness));
                EXPECT_EQ(colour[k], static_cast<int32_t>(((layer % 256) + 256) % 256));
            }
        }
    EXPECT_EQ(talus_particles_colour_layers(world.handle(), 1, 0.0, 0.0), TALUS_ERR_ARGUMENT);
    EXPECT_EQ(talus_particles_colour_layers(world.handle(), 3, 0.0, 1.0), TALUS_ERR_ARGUMENT);
}

TEST(Api, frozen_and_driven_groups_move_as_told_and_bad_groups_are_refused) {
    World world(scene_settings({0, 0, 0}, {0.1, 0.1, 0.1}, HowToRun{}), TALUS_SERIAL);
    const int32_t sand = world.material(kSceneSand);
    world.contact(sand, sand, 0.5, 0.5, 0.1);
    world.insert({{{0.05, 0.05, 0.05}, kSceneRadius, {1, 1, 1}, {}, 0, 1}, {{0.05, 0.0519, 0.05}, kSceneRadius, {}, {}, 0, 2}, {{0.02, 0.05, 0.05}, kSceneRadius, {}, {}, 0, 0}}, 0.2);
    const double velocity[3] = {0.5, 0.0, 0.0}, spin[3] = {0.0, 0.0, 7.0};
    world.check(talus_group_set(world.handle(), 1, TALUS_GROUP_FROZEN, nullptr, nullptr));
    world.check(talus_group_set(world.handle(), 2, TALUS_GROUP_DRIVEN, velocity, spin));
    world.step(100);
    double x[9], v[9], w[9];
    int64_t count = 0;
    world.check(talus_particles_copy(world.handle(), TALUS_FIELD_POSITION, 3, x, &count));
    world.check(talus_particles_copy(world.handle(), TALUS_FIELD_VELOCITY, 3, v, &count));
    world.check(talus_particles_copy(world.handle(), TALUS_FIELD_ANGULAR_VELOCITY, 3, w, &count));
    EXPECT_EQ(x[0], 0.05);
    EXPECT_EQ(x[1], 0.05);
    EXPECT_EQ(v[0], 0.0);
    EXPECT_NEAR(x[3], 0.05 + 0.5 * 100 * kSceneStep, 1e-15);
    EXPECT_EQ(x[4], 0.0519);
    EXPECT_EQ(w[5], 7.0);
    EXPECT_NEAR(v[7], -9.81 * 100 * kSceneStep, 1e-12) << "the free one falls";
    EXPECT_EQ(talus_group_set(world.handle(), 16, TALUS_GROUP_FREE, nullptr, nullptr), TALUS_ERR_ARGUMENT);
    EXPECT_EQ(talus_group_set(world.handle(), -1, TALUS_GROUP_FREE, nullptr, nullptr), TALUS_ERR_ARGUMENT);
    EXPECT_EQ(talus_group_set(world.handle(), 0, 3, nullptr, nullptr), TALUS_ERR_ARGUMENT);
}

} // namespace
} // namespace talus::test
