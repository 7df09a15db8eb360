// ranks: 1 2 3 4
// timeout: 120
// An error on one rank is the same status and message on all of them, and no rank is left waiting. A hang is a timeout here.
#include "../support/determinism.hpp"

namespace talus::test {
namespace {

/// Whether all ranks have the same status and text as rank 0. @param engine  NULL for failed creates
void expect_everywhere(talus_status status, talus_status expected, const talus_engine* engine, const char* part) {
    const char* message = engine != nullptr ? talus_engine_message(engine) : talus_message();
    EXPECT_EQ(status, expected) << message;
    EXPECT_NE(std::string(message).find(part), std::string::npos) << "\"" << message << "\" should say \"" << part << "\"";
    char text[2048] = {};
    std::snprintf(text, sizeof text, "%d %s", status, message);
    MPI_Bcast(text, sizeof text, MPI_CHAR, 0, MPI_COMM_WORLD);
    EXPECT_EQ(std::to_string(status) + " " + message, text) << "rank 0 says otherwise";
}

bool last_rank() { return world_rank_of_me() == world_size() - 1; }

/// A poisoned engine refuses to go on, still tells its counts, and a new one in the same process works.
void expect_poisoned(World& world) {
    int64_t done = 77;
    EXPECT_EQ(talus_engine_step(world.handle(), 1, &done), TALUS_ERR_STATE);
    EXPECT_EQ(done, 0);
    talus_state s;
    talus_state_init(&s);
    EXPECT_EQ(talus_engine_state(world.handle(), &s), TALUS_OK) << talus_engine_message(world.handle());
    EXPECT_EQ(s.ranks, world_size());
    std::vector<double> force(3 * static_cast<std::size_t>(s.local_particles) + 1);
    int64_t count = 0;
    EXPECT_EQ(talus_particles_copy(world.handle(), TALUS_FIELD_FORCE, s.local_particles, force.data(), &count), TALUS_ERR_STATE);
    EXPECT_EQ(talus_particles_copy(world.handle(), TALUS_FIELD_POSITION, s.local_particles, force.data(), &count), TALUS_OK) << "where they were";
    const talus_state reference = serial_reference(kGas, 10);
    World fresh = make_gas(parallel_run());
    fresh.step(10);
    EXPECT_EQ(digest_of(fresh.state()), digest_of(reference));
}

/// One insertion of one grain by each rank, with what the last rank does wrong; then the engine must be as it was.
template <class Spoil>
void expect_refused_insert(const char* part, Spoil spoil) {
    SCOPED_TRACE(part);
    const talus_state reference = serial_reference(kGas, 20);
    World world = make_gas(parallel_run());
    world.step(10);
    const talus_state before = world.state();
    int64_t label = 100000 + world.rank();
    double position[3] = {0.0015 + 0.003 * world.rank(), 0.0015, 0.0015}, velocity[3] = {0, 0, 0}, radius = 0.1 * kSceneRadius;
    int32_t material = 0, group = 0, colour = 0;
    talus_particles p{};
    p.struct_size = sizeof p;
    p.count = 1;
    p.label = &label;
    p.position = position;
    p.velocity = velocity;
    p.radius = &radius;
    p.material = &material;
    p.group = &group;
    p.colour = &colour;
    if (last_rank()) spoil(p, label, position, velocity, radius, material, group, colour);
    const talus_status status = talus_particles_insert(world.handle(), &p, 0.01);
    expect_everywhere(status, TALUS_ERR_ARGUMENT, world.handle(), part);
    EXPECT_EQ(digest_of(world.state()), digest_of(before));
    EXPECT_EQ(world.state().particles, 512);
    world.step(10);
    EXPECT_EQ(digest_of(world.state()), digest_of(reference));
}

TEST(Errors, a_bad_grain_given_by_one_rank_is_refused_on_all_and_changes_nothing) {
    expect_refused_insert("not finite", [](auto&, auto&, auto& x, auto&, auto&, auto&, auto&, auto&) { x[1] = NAN; });
    expect_refused_insert("not finite", [](auto&, auto&, auto&, auto& v, auto&, auto&, auto&, auto&) { v[2] = HUGE_VAL; });
    expect_refused_insert("outside the domain", [](auto&, auto&, auto& x, auto&, auto&, auto&, auto&, auto&) { x[0] = 5.0; });
    expect_refused_insert("radius", [](auto&, auto&, auto&, auto&, auto& r, auto&, auto&, auto&) { r = -1.0; });
    expect_refused_insert("label", [](auto&, auto& label, auto&, auto&, auto&, auto&, auto&, auto&) { label = -4; });
    expect_refused_insert("label 17 is given twice", [](auto&, auto& label, auto&, auto&, auto&, auto&, auto&, auto&) { label = 17; });
    expect_refused_insert("material", [](auto&, auto&, auto&, auto&, auto&, auto& m, auto&, auto&) { m = 3; });
    expect_refused_insert("group", [](auto&, auto&, auto&, auto&, auto&, auto&, auto& g, auto&) { g = 16; });
    expect_refused_insert("colour", [](auto&, auto&, auto&, auto&, auto&, auto&, auto&, auto& c) { c = 256; });
    expect_refused_insert("particles.position is NULL", [](auto& p, auto&, auto&, auto&, auto&, auto&, auto&, auto&) { p.position = nullptr; });
    expect_refused_insert("struct_size", [](auto& p, auto&, auto&, auto&, auto&, auto&, auto&, auto&) { p.struct_size = 0; });
    expect_refused_insert("count", [](auto& p, auto&, auto&, auto&, auto&, auto&, auto&, auto&) { p.count = -1; });
}

TEST(Errors, a_null_pointer_on_one_rank_is_the_error_of_all) {
    World world = make_gas(parallel_run());
    world.step(2);
    const bool bad = last_rank();
    talus_particles none{};
    none.struct_size = sizeof none;
    expect_everywhere(talus_particles_insert(world.handle(), bad ? nullptr : &none, 0.1), TALUS_ERR_ARGUMENT, world.handle(), "particles is NULL");
    const double lo[3] = {0, 0, 0}, hi[3] = {0.01, 0.01, 0.01};
    double stress[9], fraction;
    expect_everywhere(talus_engine_stress(world.handle(), lo, hi, bad ? nullptr : stress, &fraction, nullptr), TALUS_ERR_ARGUMENT, world.handle(), "out_stress is NULL");
    int64_t sum[3];
    expect_everywhere(talus_engine_internal_force_sum(world.handle(), bad ? nullptr : sum, nullptr), TALUS_ERR_ARGUMENT, world.handle(), "out_sum is NULL");
    talus_phase phases[16];
    talus_phase_init(phases);
    int32_t n = 16;
    expect_everywhere(talus_engine_phases(world.handle(), &n, bad ? nullptr : phases), TALUS_ERR_ARGUMENT, world.handle(), "out_phases is NULL");
    world.step(1);

    const talus_settings s = scene_settings({0, 0, 0}, {1, 1, 1}, HowToRun{});
    talus_engine* engine = nullptr;
    expect_everywhere(talus_engine_create_mpi(bad ? nullptr : &s, world_handle(), &engine), TALUS_ERR_ARGUMENT, nullptr, "settings is NULL");
    expect_everywhere(talus_engine_create_mpi(&s, world_handle(), bad ? nullptr : &engine), TALUS_ERR_ARGUMENT, nullptr, "out_engine is NULL");
    EXPECT_EQ(engine, nullptr);
}

TEST(Errors, settings_that_are_wrong_on_one_rank_only_make_no_engine_anywhere) {
    talus_settings s = scene_settings({0, 0, 0}, {1, 1, 1}, HowToRun{});
    if (last_rank()) s.periodic[1] = 5;
    talus_engine* engine = nullptr;
    expect_everywhere(talus_engine_create_mpi(&s, world_handle(), &engine), TALUS_ERR_ARGUMENT, nullptr, "periodic[1]");
    EXPECT_EQ(engine, nullptr);
}

TEST(Errors, ranks_that_ask_for_different_numbers_of_steps_are_refused_and_may_go_on) {
    const talus_state reference = serial_reference(kGas, 10);
    World world = make_gas(parallel_run());
    int64_t done = -1;
    if (world.ranks() > 1) expect_everywhere(talus_engine_step(world.handle(), last_rank() ? 6 : 5, &done), TALUS_ERR_ARGUMENT, world.handle(), "n_steps: the values differ between ranks");
    expect_everywhere(talus_engine_step(world.handle(), -1, &done), TALUS_ERR_ARGUMENT, world.handle(), "n_steps = -1");
    EXPECT_EQ(done, 0);
    world.step(10);
    EXPECT_EQ(digest_of(world.state()), digest_of(reference));
}

/// Grains in a closed box without walls and without gravity; the last of them is what a test makes of it.
World make_open(Grain last) {
    talus_settings s = scene_settings({0, 0, 0}, {0.04, 0.04, 0.04}, parallel_run());
    for (double& g : s.gravity) g = 0.0;
    World world(s, world_handle());
    const int32_t sand = world.material(kSceneSand);
    world.contact(sand, sand, 0.5, 0.5, 0.1);
    std::vector<Grain> grains = lattice(8, 8, 8, {0.01, 0.01, 0.01}, 0.0, 0.0);
    grains.push_back(last);
    world.insert(grains, 0.05);
    return world;
}

TEST(Errors, a_grain_that_leaves_the_domain_is_lost_with_its_label_on_every_rank) {
    World world = make_open({{0.03, 0.035, 0.03}, kSceneRadius, {0.3, 4.0, 0.0}, {}});
    int64_t done = -1;
    expect_everywhere(talus_engine_step(world.handle(), 1000, &done), TALUS_ERR_LOST, world.handle(), "grain 512 left the domain on axis y");
    EXPECT_GT(done, 100);
    EXPECT_LT(done, 200);
    expect_poisoned(world);
}

TEST(Errors, a_force_above_the_cap_stops_every_rank_and_names_the_pair) {
    // A driven grain is pushed through a frozen one.
    World world = make_open({{0.036, 0.02, 0.03}, kSceneRadius, {}, {}, 0, 2});
    world.insert({{{0.0335, 0.02, 0.03}, kSceneRadius, {}, {}, 0, 1}}, 0.05, 1000);
    const double velocity[3] = {5.0, 0.0, 0.0};
    world.check(talus_group_set(world.handle(), 1, TALUS_GROUP_DRIVEN, velocity, nullptr));
    world.check(talus_group_set(world.handle(), 2, TALUS_GROUP_FROZEN, nullptr, nullptr));
    expect_everywhere(talus_engine_step(world.handle(), 200, nullptr), TALUS_ERR_UNSTABLE, world.handle(), "grain 512 and grain 1000 push each other");
    expect_poisoned(world);
}

TEST(Errors, a_force_above_the_cap_at_the_very_first_evaluation_stops_every_rank_too) {
    World world = make_open({{0.03, 0.03, 0.03}, kSceneRadius, {}, {}});
    world.insert({{{0.0319, 0.03, 0.03}, kSceneRadius, {-1e9, 0.0, 0.0}, {}}}, 0.2, 1000);
    expect_everywhere(talus_engine_step(world.handle(), 0, nullptr), TALUS_ERR_UNSTABLE, world.handle(), "grain 512 and grain 1000 push each other");
    expect_poisoned(world);
}

TEST(Errors, a_velocity_that_is_not_a_number_stops_every_rank) {
    World world = make_open({{0.03, 0.03, 0.03}, kSceneRadius, {}, {}, 0, 3});
    // Only the one grain, so only one rank, is spoiled.
    const double velocity[3] = {0.0, NAN, 0.0};
    const talus_status status = talus_group_set(world.handle(), 3, TALUS_GROUP_DRIVEN, velocity, nullptr);
    if (status == TALUS_OK) {
        const talus_status after = talus_engine_step(world.handle(), 10, nullptr);
        expect_everywhere(after, TALUS_ERR_UNSTABLE, world.handle(), "not finite");
        expect_poisoned(world);
    } else {
        expect_everywhere(status, TALUS_ERR_ARGUMENT, world.handle(), "finite");
    }
}

TEST(Errors, a_grain_that_moves_by_half_its_size_in_a_step_is_followed_until_it_leaves_the_domain) {
    World world = make_open({{0.039, 0.035, 0.03}, kSceneRadius, {-100.0, 0.0, 0.0}, {}});
    int64_t done = -1;
    expect_everywhere(talus_engine_step(world.handle(), 100, &done), TALUS_ERR_LOST, world.handle(), "grain 512 left the domain on axis x");
    EXPECT_GE(done, 38);
    EXPECT_LE(done, 42);
    expect_poisoned(world);
}

TEST(Errors, too_large_a_step_and_too_short_a_period_are_refused_alike_on_every_rank) {
    World world = make_gas(parallel_run());
    world.check(talus_engine_set_time_step(world.handle(), 1.0));
    expect_everywhere(talus_engine_step(world.handle(), 1, nullptr), TALUS_ERR_ARGUMENT, world.handle(), "critical step");
    world.check(talus_engine_set_time_step(world.handle(), kSceneStep));
    world.step(1);

    talus_settings s = scene_settings({0, 0, 0}, {0.0043, 0.02, 0.02}, parallel_run());
    s.periodic[0] = 1;
    s.rank_grid[0] = 1;
    World narrow(s, world_handle());
    const int32_t sand = narrow.material(kSceneSand);
    narrow.contact(sand, sand, 0.5, 0.5, 0.1);
    talus_fill f;
    talus_fill_init(&f);
    f.radius_min = f.radius_max = kSceneRadius;
    f.hi[0] = 0.004;
    f.hi[1] = f.hi[2] = 0.02;
    expect_everywhere(talus_particles_fill(narrow.handle(), &f, nullptr), TALUS_ERR_ARGUMENT, narrow.handle(), "periodic length along x");
}

TEST(Errors, more_ranks_than_can_hold_a_halo_are_refused_with_the_cure) {
    talus_settings s = scene_settings({0, 0, 0}, {0.0021 * world_size(), 0.02, 0.02}, parallel_run());
    s.rank_grid[0] = world_size();
    World world(s, world_handle());
    const int32_t sand = world.material(kSceneSand);
    world.contact(sand, sand, 0.5, 0.5, 0.1);
    talus_fill f;
    talus_fill_init(&f);
    f.radius_min = f.radius_max = kSceneRadius;
    f.hi[0] = 0.0021 * world_size();
    f.hi[1] = f.hi[2] = 0.02;
    f.room = 0.0;
    const talus_status status = talus_particles_fill(world.handle(), &f, nullptr);
    if (world.ranks() > 1)
        expect_everywhere(status, TALUS_ERR_ARGUMENT, world.handle(), "use fewer ranks");
    else
        EXPECT_EQ(status, TALUS_OK);
}

TEST(Errors, several_engines_at_once_do_not_disturb_each_other) {
    const talus_state gas_reference = serial_reference(kGas, 40), shear_reference = serial_reference(kShear, 40);
    World gas = make_gas(parallel_run());
    World shear = make_shear(parallel_run());
    World alone = make_gas(HowToRun{});
    for (int k = 0; k < 4; ++k) {
        gas.step(10);
        shear.step(10);
        alone.step(10);
    }
    EXPECT_EQ(digest_of(gas.state()), digest_of(gas_reference));
    EXPECT_EQ(digest_of(shear.state()), digest_of(shear_reference));
    EXPECT_EQ(digest_of(alone.state()), digest_of(gas_reference));
}

TEST(Errors, a_stop_asked_for_on_one_rank_ends_the_call_after_the_same_step_on_all) {
    const talus_state reference = serial_reference(kGas, 50);
    World world = make_gas(parallel_run());
    world.step(1);
    if (last_rank()) talus_engine_request_stop(world.handle());
    int64_t done = -1;
    const talus_status status = talus_engine_step(world.handle(), 40, &done);
    expect_everywhere(status, TALUS_STOPPED, world.handle(), "");
    EXPECT_LT(done, 40);
    int64_t least = 0;
    MPI_Allreduce(&done, &least, 1, MPI_INT64_T, MPI_MIN, MPI_COMM_WORLD);
    EXPECT_EQ(done, least);
    world.step(49 - done);
    EXPECT_EQ(digest_of(world.state()), digest_of(reference));
}

TEST(Errors, a_grain_that_outruns_the_lists_within_a_step_stops_the_run_on_all_ranks) {
    World world = make_gas(parallel_run());
    ASSERT_EQ(talus_particles_stop(world.handle()), TALUS_OK);
    world.step(1);
    // Two grains at rest, half in each other: nothing foresees how far one step will throw them.
    const int64_t label[2] = {200000, 200001};
    const double x = 0.0015, radius[2] = {0.6 * kSceneRadius, 0.6 * kSceneRadius};
    const double position[6] = {x, x, x, x + 1.1 * radius[0], x, x};
    talus_particles p;
    talus_particles_init(&p);
    p.count = world.rank() == 0 ? 2 : 0;
    p.label = label;
    p.position = position;
    p.radius = radius;
    ASSERT_EQ(talus_particles_insert(world.handle(), &p, 1.0), TALUS_OK) << talus_engine_message(world.handle());
    double critical = 0.0;
    ASSERT_EQ(talus_engine_critical_step(world.handle(), &critical), TALUS_OK);
    ASSERT_EQ(talus_engine_set_time_step(world.handle(), 0.49 * critical), TALUS_OK);
    int64_t done = -1;
    expect_everywhere(talus_engine_step(world.handle(), 20, &done), TALUS_ERR_UNSTABLE, world.handle(), "outran the list");
    EXPECT_LT(done, 5);
    expect_poisoned(world);
}

TEST(Errors, a_value_that_only_one_rank_was_given_is_refused_at_the_next_step_on_all) {
    if (world_size() == 1) GTEST_SKIP() << "one rank agrees with itself";
    World world = make_gas(parallel_run());
    world.step(10);
    const double usual[3] = {0.0, 0.0, 0.0}, other[3] = {0.0, -1.0, 0.0};
    int64_t done = 77;
    const auto refused = [&](const char* part) {
        expect_everywhere(talus_engine_step(world.handle(), 5, &done), TALUS_ERR_ARGUMENT, world.handle(), part);
        EXPECT_EQ(done, 0);
    };
    if (last_rank()) talus_engine_set_gravity(world.handle(), other);
    refused("settings: the values differ between ranks");
    // Told the same again, on that rank alone, the run goes on where it was.
    if (last_rank()) talus_engine_set_gravity(world.handle(), usual);
    if (last_rank()) talus_group_set(world.handle(), 3, TALUS_GROUP_FROZEN, nullptr, nullptr);
    refused("groups: the values differ between ranks");
    if (last_rank()) talus_group_set(world.handle(), 3, TALUS_GROUP_FREE, nullptr, nullptr);
    talus_contact c;
    talus_contact_init(&c);
    c.friction = 0.125 * world.rank();
    talus_contact_set(world.handle(), 0, 0, &c);
    refused("contacts: the values differ between ranks");
}

TEST(Errors, numbers_that_differ_between_ranks_are_refused_by_the_call_itself) {
    if (world_size() == 1) GTEST_SKIP() << "one rank agrees with itself";
    const talus_state reference = serial_reference(kGas, 20);
    World world = make_gas(parallel_run());
    world.step(10);
    const double v[3] = {0.01 * world.rank(), 0.0, 0.0};
    expect_everywhere(talus_particles_add_velocity(world.handle(), v), TALUS_ERR_ARGUMENT, world.handle(), "velocity: the values differ between ranks");
    int64_t removed = 0;
    expect_everywhere(talus_particles_remove_above(world.handle(), 1, 0.5 + world.rank(), &removed), TALUS_ERR_ARGUMENT, world.handle(), "differ between ranks");
    expect_everywhere(talus_particles_colour_layers(world.handle(), last_rank() ? 1 : 0, 0.0, 0.1), TALUS_ERR_ARGUMENT, world.handle(), "differ between ranks");
    world.step(10);
    EXPECT_EQ(digest_of(world.state()), digest_of(reference)) << "what was refused must have changed nothing";
}

TEST(Errors, a_stop_asked_for_in_the_last_step_of_a_call_is_told_by_that_call) {
    World world = make_gas(parallel_run());
    world.step(1);
    if (last_rank()) talus_engine_request_stop(world.handle());
    int64_t done = -1;
    expect_everywhere(talus_engine_step(world.handle(), 1, &done), TALUS_STOPPED, world.handle(), "");
    EXPECT_EQ(done, 1);
    expect_everywhere(talus_engine_step(world.handle(), 3, &done), TALUS_OK, world.handle(), "");
    EXPECT_EQ(done, 3);
}

} // namespace
} // namespace talus::test
