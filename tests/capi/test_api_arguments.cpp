// The C ABI, function by function: bad arguments give a status and change nothing, structs of other sizes are read.
#include <gtest/gtest.h>

#include <cstring>
#include <functional>

#include "../support/small_world.hpp"

namespace talus::test {
namespace {

std::string message(World& w) { return talus_engine_message(w.handle()); }

/// Every function that takes an engine, called with it and with otherwise good arguments.
std::vector<std::pair<const char*, std::function<talus_status(talus_engine*)>>> all_calls() {
    static talus_laws laws;
    static talus_material material;
    static talus_contact contact;
    static talus_wall wall;
    static talus_wall_state wall_state;
    static talus_particles particles;
    static talus_fill fill;
    static talus_state state;
    static talus_energy energy;
    static talus_view view;
    static talus_phase phases[16];
    static talus_rank a_rank;
    static talus_memory memory;
    static talus_kept* kept;
    static double v[9];
    static int64_t n[3];
    static int32_t i, j;
    static uint64_t g;
    const double lo[3] = {0, 0, 0}, hi[3] = {0.01, 0.01, 0.01};
    static double box[2][3];
    std::memcpy(box[0], lo, sizeof lo);
    std::memcpy(box[1], hi, sizeof hi);
    talus_laws_init(&laws);
    talus_material_init(&material);
    talus_contact_init(&contact);
    talus_wall_init(&wall);
    wall_state.struct_size = sizeof wall_state;
    particles.struct_size = sizeof particles;
    talus_fill_init(&fill);
    talus_state_init(&state);
    talus_energy_init(&energy);
    view.struct_size = sizeof view;
    i = 16;
    talus_phase_init(phases);
    talus_rank_init(&a_rank);
    talus_memory_init(&memory);
    return {
        {"rank", [](talus_engine* e) { return talus_engine_rank(e, &i, &j); }},
        {"set_laws", [](talus_engine* e) { return talus_engine_set_laws(e, &laws); }},
        {"set_time_step", [](talus_engine* e) { return talus_engine_set_time_step(e, 1e-6); }},
        {"set_gravity", [](talus_engine* e) { return talus_engine_set_gravity(e, v); }},
        {"critical_step", [](talus_engine* e) { return talus_engine_critical_step(e, v); }},
        {"material_add", [](talus_engine* e) { return talus_material_add(e, &material, &j); }},
        {"contact_set", [](talus_engine* e) { return talus_contact_set(e, 0, 0, &contact); }},
        {"wall_add", [](talus_engine* e) { return talus_wall_add(e, &wall, &j); }},
        {"wall_set_velocity", [](talus_engine* e) { return talus_wall_set_velocity(e, 0, v); }},
        {"wall_get", [](talus_engine* e) { return talus_wall_get(e, 0, &wall_state); }},
        {"insert", [](talus_engine* e) { return talus_particles_insert(e, &particles, 0.1); }},
        {"fill", [](talus_engine* e) { return talus_particles_fill(e, &fill, n); }},
        {"group_set", [](talus_engine* e) { return talus_group_set(e, 0, 0, nullptr, nullptr); }},
        {"add_velocity", [](talus_engine* e) { return talus_particles_add_velocity(e, v); }},
        {"stop", [](talus_engine* e) { return talus_particles_stop(e); }},
        {"colour_layers", [](talus_engine* e) { return talus_particles_colour_layers(e, 1, 0.0, 1.0); }},
        {"remove_above", [](talus_engine* e) { return talus_particles_remove_above(e, 1, 1.0, n); }},
        {"mark_reference", [](talus_engine* e) { return talus_particles_mark_reference(e); }},
        {"step", [](talus_engine* e) { return talus_engine_step(e, 1, n); }},
        {"state", [](talus_engine* e) { return talus_engine_state(e, &state); }},
        {"energy", [](talus_engine* e) { return talus_engine_energy(e, &energy); }},
        {"stress", [](talus_engine* e) { return talus_engine_stress(e, box[0], box[1], v, v, v); }},
        {"internal_force_sum", [](talus_engine* e) { return talus_engine_internal_force_sum(e, n, v); }},
        {"copy", [](talus_engine* e) { return talus_particles_copy(e, TALUS_FIELD_RADIUS, 0, nullptr, n); }},
        {"gather", [](talus_engine* e) { return talus_particles_gather(e, TALUS_FIELD_RADIUS, 0, nullptr, n); }},
        {"view", [](talus_engine* e) { return talus_particles_view(e, TALUS_FIELD_RADIUS, &view); }},
        {"generation", [](talus_engine* e) { return talus_engine_generation(e, &g); }},
        {"phases", [](talus_engine* e) { return talus_engine_phases(e, &i, phases); }},
        {"ranks", [](talus_engine* e) { return talus_engine_ranks(e, &i, &a_rank); }},
        {"memory", [](talus_engine* e) { return talus_engine_memory(e, &memory); }},
        {"contacts", [](talus_engine* e) { return talus_contacts_copy(e, TALUS_CONTACT_FORCE, 0, nullptr, n); }},
        {"advance_to", [](talus_engine* e) { return talus_engine_advance_to(e, 1.0, n); }},
        {"remove", [](talus_engine* e) { return talus_particles_remove(e, 0, nullptr, n); }},
        {"remove_box", [](talus_engine* e) { return talus_particles_remove_box(e, box[0], box[1], n); }},
        {"keep", [](talus_engine* e) { return talus_engine_keep(e, &kept); }},
        {"restore", [](talus_engine* e) { return talus_engine_restore(e, kept); }},
        {"checkpoint_save", [](talus_engine* e) { return talus_checkpoint_save(e, "never-written"); }},
        {"snapshot_write", [](talus_engine* e) { return talus_snapshot_write(e, "never-written.hdf"); }},
        {"trace_start", [](talus_engine* e) { return talus_trace_start(e, "never-written", 1); }},
    };
}

TEST(ApiArguments, every_function_answers_a_null_engine_with_a_status_and_a_message) {
    for (const auto& [name, call] : all_calls()) {
        EXPECT_EQ(call(nullptr), TALUS_ERR_ARGUMENT) << name;
        EXPECT_NE(std::string(talus_message()).find("NULL"), std::string::npos) << name;
    }
    talus_engine_destroy(nullptr);
    talus_engine_request_stop(nullptr);
    EXPECT_NE(talus_engine_message(nullptr), nullptr);
}

TEST(ApiArguments, every_function_refuses_null_structs_and_outputs_and_the_engine_goes_on) {
    World world = small_world();
    world.step(5);
    const auto before = digest(world);
    talus_engine* e = world.handle();
    const double lo[3] = {0, 0, 0}, hi[3] = {1, 1, 1};
    double v[9];
    int32_t n = 16;
    const std::pair<const char*, std::function<talus_status()>> calls[] = {
        {"laws_init", [] { return talus_laws_init(nullptr); }},
        {"settings_init", [] { return talus_settings_init(nullptr); }},
        {"material_init", [] { return talus_material_init(nullptr); }},
        {"contact_init", [] { return talus_contact_init(nullptr); }},
        {"wall_init", [] { return talus_wall_init(nullptr); }},
        {"fill_init", [] { return talus_fill_init(nullptr); }},
        {"state_init", [] { return talus_state_init(nullptr); }},
        {"energy_init", [] { return talus_energy_init(nullptr); }},
        {"create", [] { return talus_engine_create(nullptr, nullptr); }},
        {"load", [] { return talus_checkpoint_load(nullptr, nullptr, TALUS_SERIAL, nullptr); }},
        {"set_laws", [&] { return talus_engine_set_laws(e, nullptr); }},
        {"set_gravity", [&] { return talus_engine_set_gravity(e, nullptr); }},
        {"critical_step", [&] { return talus_engine_critical_step(e, nullptr); }},
        {"material_add", [&] { return talus_material_add(e, nullptr, nullptr); }},
        {"contact_set", [&] { return talus_contact_set(e, 0, 0, nullptr); }},
        {"wall_add", [&] { return talus_wall_add(e, nullptr, nullptr); }},
        {"wall_set_velocity", [&] { return talus_wall_set_velocity(e, 0, nullptr); }},
        {"wall_get", [&] { return talus_wall_get(e, 0, nullptr); }},
        {"insert", [&] { return talus_particles_insert(e, nullptr, 0.1); }},
        {"fill", [&] { return talus_particles_fill(e, nullptr, nullptr); }},
        {"add_velocity", [&] { return talus_particles_add_velocity(e, nullptr); }},
        {"state", [&] { return talus_engine_state(e, nullptr); }},
        {"energy", [&] { return talus_engine_energy(e, nullptr); }},
        {"stress lo", [&] { return talus_engine_stress(e, nullptr, hi, v, v, v); }},
        {"stress hi", [&] { return talus_engine_stress(e, lo, nullptr, v, v, v); }},
        {"stress out", [&] { return talus_engine_stress(e, lo, hi, nullptr, v, v); }},
        {"internal_force_sum", [&] { return talus_engine_internal_force_sum(e, nullptr, nullptr); }},
        {"copy", [&] { return talus_particles_copy(e, TALUS_FIELD_RADIUS, 1000, nullptr, nullptr); }},
        {"gather", [&] { return talus_particles_gather(e, TALUS_FIELD_RADIUS, 1000, nullptr, nullptr); }},
        {"view", [&] { return talus_particles_view(e, TALUS_FIELD_RADIUS, nullptr); }},
        {"generation", [&] { return talus_engine_generation(e, nullptr); }},
        {"phases count", [&] { return talus_engine_phases(e, nullptr, nullptr); }},
        {"phases", [&] { return talus_engine_phases(e, &n, nullptr); }},
        {"ranks", [&] { return talus_engine_ranks(e, &n, nullptr); }},
        {"memory", [&] { return talus_engine_memory(e, nullptr); }},
        {"contacts", [&] { return talus_contacts_copy(e, TALUS_CONTACT_FORCE, 0, nullptr, nullptr); }},
        {"remove", [&] { return talus_particles_remove(e, 2, nullptr, nullptr); }},
        {"remove_box", [&] { return talus_particles_remove_box(e, nullptr, hi, nullptr); }},
        {"keep", [&] { return talus_engine_keep(e, nullptr); }},
        {"restore", [&] { return talus_engine_restore(e, nullptr); }},
        {"memory_init", [] { return talus_memory_init(nullptr); }},
        {"phase_init", [] { return talus_phase_init(nullptr); }},
        {"rank_init", [] { return talus_rank_init(nullptr); }},
        {"checkpoint_save", [&] { return talus_checkpoint_save(e, nullptr); }},
        {"snapshot_write", [&] { return talus_snapshot_write(e, nullptr); }},
        {"trace_start", [&] { return talus_trace_start(e, nullptr, 3); }},
    };
    for (const auto& [name, call] : calls) EXPECT_EQ(call(), TALUS_ERR_ARGUMENT) << name;
    EXPECT_EQ(digest(world), before);
    world.step(5);
}

TEST(ApiArguments, structs_that_nobody_initialised_are_told_from_initialised_ones) {
    World world = small_world();
    world.step(1);
    talus_engine* e = world.handle();
    const auto refused = [&](talus_status status) {
        EXPECT_EQ(status, TALUS_ERR_ARGUMENT);
        EXPECT_NE(message(world).find("_init"), std::string::npos) << message(world);
    };
    talus_material m{};
    refused(talus_material_add(e, &m, nullptr));
    talus_contact c{};
    refused(talus_contact_set(e, 0, 0, &c));
    talus_wall w{};
    refused(talus_wall_add(e, &w, nullptr));
    talus_laws l{};
    refused(talus_engine_set_laws(e, &l));
    talus_fill f{};
    refused(talus_particles_fill(e, &f, nullptr));
    talus_particles p{};
    refused(talus_particles_insert(e, &p, 0.1));
    talus_state s{};
    refused(talus_engine_state(e, &s));
    talus_energy en{};
    refused(talus_engine_energy(e, &en));
    talus_wall_state ws{};
    refused(talus_wall_get(e, 0, &ws));
    talus_view v{};
    refused(talus_particles_view(e, TALUS_FIELD_RADIUS, &v));
    talus_settings none{};
    talus_engine* made = nullptr;
    EXPECT_EQ(talus_engine_create(&none, &made), TALUS_ERR_ARGUMENT);
    EXPECT_NE(std::string(talus_message()).find("_init"), std::string::npos);
    std::memset(static_cast<void*>(&none), 0xee, sizeof none);
    EXPECT_EQ(talus_engine_create(&none, &made), TALUS_ERR_ARGUMENT);
    EXPECT_EQ(made, nullptr);
}

TEST(ApiArguments, an_older_caller_with_smaller_structs_is_served_with_defaults_and_nothing_beyond_its_size_is_written) {
    World world = small_world();
    world.step(3);
    talus_state s, whole = world.state();
    std::memset(static_cast<void*>(&s), 0x5a, sizeof s);
    s.struct_size = offsetof(talus_state, rebuilds);
    EXPECT_EQ(talus_engine_state(world.handle(), &s), TALUS_OK);
    EXPECT_EQ(s.struct_size, offsetof(talus_state, rebuilds));
    EXPECT_EQ(s.contacts, whole.contacts);
    EXPECT_EQ(s.sliding_contacts, whole.sliding_contacts);
    const auto* bytes = reinterpret_cast<const unsigned char*>(&s);
    for (std::size_t k = offsetof(talus_state, rebuilds); k < sizeof s; ++k) ASSERT_EQ(bytes[k], 0x5a) << k;

    // Settings that end before the laws: their defaults hold.
    talus_settings old = scene_settings({0, 0, 0}, {0.1, 0.1, 0.1}, HowToRun{});
    std::memset(static_cast<void*>(&old.laws), 0xff, sizeof old.laws);
    old.struct_size = offsetof(talus_settings, laws);
    EXPECT_NO_THROW(World(old, TALUS_SERIAL));
    // A newer caller with a larger struct is read as far as this library knows.
    struct {
        talus_material known;
        double more[4];
    } newer{};
    talus_material_init(&newer.known);
    newer.known.young = 1e7;
    newer.known.density = 1000.0;
    newer.known.struct_size = sizeof newer;
    World fresh(scene_settings({0, 0, 0}, {0.1, 0.1, 0.1}, HowToRun{}), TALUS_SERIAL);
    EXPECT_EQ(talus_material_add(fresh.handle(), &newer.known, nullptr), TALUS_OK);
}

TEST(ApiArguments, statuses_have_names_and_versions_agree) {
    for (talus_status s = -9; s <= 1; ++s) EXPECT_EQ(std::string(talus_status_string(s)).rfind("TALUS_", 0), 0u) << s;
    EXPECT_STREQ(talus_status_string(-77), "unknown status");
    EXPECT_EQ(talus_version(), TALUS_VERSION_NUMBER);
    EXPECT_GT(std::strlen(talus_build_info()), 10u);
    talus_settings s = scene_settings({0, 0, 0}, {1, 1, 1}, HowToRun{});
    s.header_version = 990000;
    talus_engine* e = nullptr;
    EXPECT_EQ(talus_engine_create(&s, &e), TALUS_ERR_ARGUMENT);
    EXPECT_NE(std::string(talus_message()).find("990000"), std::string::npos);
}

TEST(ApiArguments, rank_grid_is_that_of_least_surface) {
    const double sheet[3] = {1.0, 0.02, 1.0}, flat[3] = {1.0, 0.0, 1.0};
    const int32_t free[3] = {0, 0, 0}, tall[3] = {0, 4, 0}, five[3] = {5, 0, 0}, below[3] = {0, -1, 0};
    int32_t grid[3] = {7, 7, 7};
    ASSERT_EQ(talus_rank_grid(sheet, nullptr, 16384, free, grid), TALUS_OK);
    EXPECT_EQ(grid[0] * grid[1] * grid[2], 16384);
    EXPECT_EQ(grid[0], 64); // halves, 64 x 128 of each: less surface than 128 x 128 columns
    EXPECT_EQ(grid[1], 2);
    ASSERT_EQ(talus_rank_grid(sheet, nullptr, 12, nullptr, grid), TALUS_OK);
    EXPECT_EQ(grid[0] * grid[2], 12);
    ASSERT_EQ(talus_rank_grid(sheet, nullptr, 12, tall, grid), TALUS_OK);
    EXPECT_EQ(grid[1], 4);
    grid[0] = 7;
    EXPECT_EQ(talus_rank_grid(sheet, nullptr, 12, five, grid), TALUS_ERR_ARGUMENT);
    EXPECT_NE(std::string(talus_message()).find("12 ranks"), std::string::npos);
    EXPECT_EQ(talus_rank_grid(sheet, nullptr, 0, free, grid), TALUS_ERR_ARGUMENT);
    EXPECT_EQ(talus_rank_grid(flat, nullptr, 12, free, grid), TALUS_ERR_ARGUMENT);
    EXPECT_EQ(talus_rank_grid(sheet, nullptr, 12, below, grid), TALUS_ERR_ARGUMENT);
    EXPECT_EQ(talus_rank_grid(nullptr, nullptr, 12, free, grid), TALUS_ERR_ARGUMENT);
    EXPECT_EQ(talus_rank_grid(sheet, nullptr, 12, free, nullptr), TALUS_ERR_ARGUMENT);
    EXPECT_EQ(grid[0], 7) << "outputs are untouched on failure";
}

TEST(ApiArguments, an_engine_over_ranks_without_mpi_is_a_clear_error) {
    const talus_settings s = scene_settings({0, 0, 0}, {1, 1, 1}, HowToRun{});
    talus_engine* e = nullptr;
    EXPECT_EQ(talus_engine_create_mpi(&s, 0, &e), TALUS_ERR_STATE);
    EXPECT_NE(std::string(talus_message()).find("not initialised"), std::string::npos);
    EXPECT_EQ(e, nullptr);
}

} // namespace
} // namespace talus::test
