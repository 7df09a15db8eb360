// Contacts one by one, grains taken out by place and name, stepping to a time, and what an engine holds.
#include <gtest/gtest.h>

#include <numeric>

#include "../support/sheared_block.hpp"

namespace talus::test {
namespace {

int64_t n_contacts(World& world) {
    int64_t n = 0;
    world.check(talus_contacts_copy(world.handle(), TALUS_CONTACT_LABELS, 0, nullptr, &n));
    return n;
}
template <class T>
std::vector<T> contacts(World& world, int32_t field, std::size_t components) {
    int64_t n = n_contacts(world);
    std::vector<T> v(components * static_cast<std::size_t>(n));
    if (n > 0) world.check(talus_contacts_copy(world.handle(), field, n, v.data(), &n));
    return v;
}
std::vector<double> copy(World& world, int32_t field, std::size_t components) {
    int64_t n = 0;
    std::vector<double> v(components * static_cast<std::size_t>(world.state().particles));
    world.check(talus_particles_copy(world.handle(), field, static_cast<int64_t>(v.size() / components), v.data(), &n));
    return v;
}
World block() { return make_sheared_block({8, 5, 6}, 0.2, HowToRun{}); }

TEST(Contacts, two_grains_on_a_floor_are_seen_with_their_partner_place_normal_and_overlap) {
    talus_settings s = scene_settings({-1, -1, -1}, {1, 1, 1}, HowToRun{});
    World world(s, TALUS_SERIAL);
    const int32_t sand = world.material(kSceneSand);
    world.contact(sand, sand, 0.5, 0.5, 0.0);
    world.wall(sand, {0, 0, 0}, {0, 1, 0});
    const double r = kSceneRadius, overlap = 0.01 * r;
    Grain lower, upper;
    lower.radius = upper.radius = r;
    lower.position = {0, r - overlap, 0};
    upper.position = {0, 3 * r - 3 * overlap, 0};
    world.insert({upper, lower}, 0.1, 7); // labels 7 and 8: i is the upper one
    ASSERT_EQ(n_contacts(world), 2);
    EXPECT_EQ(contacts<int64_t>(world, TALUS_CONTACT_LABELS, 2), (std::vector<int64_t>{7, 8, 8, TALUS_WALL_LABEL}));
    const auto normal = contacts<double>(world, TALUS_CONTACT_NORMAL, 3), point = contacts<double>(world, TALUS_CONTACT_POINT, 3), depth = contacts<double>(world, TALUS_CONTACT_OVERLAP, 1);
    EXPECT_NEAR(normal[1], 1.0, 1e-15);
    EXPECT_NEAR(normal[4], 1.0, 1e-15);
    EXPECT_NEAR(depth[0], 2 * overlap, 1e-12 * r);
    EXPECT_NEAR(depth[1], overlap, 1e-12 * r);
    EXPECT_NEAR(point[1], 2 * r - 2 * overlap, 1e-12 * r);
    // At rest, the forces that contacts give are those that grains have got.
    const auto force = contacts<double>(world, TALUS_CONTACT_FORCE, 3), net = copy(world, TALUS_FIELD_FORCE, 3);
    EXPECT_GT(force[1], 0.0);
    EXPECT_NEAR(net[1], force[1], 1e-9 * force[1]);
    EXPECT_NEAR(net[4], force[4] - force[1], 1e-9 * force[1]);
    EXPECT_EQ(contacts<int32_t>(world, TALUS_CONTACT_SLIDING, 1), (std::vector<int32_t>{0, 0}));
}

TEST(Contacts, are_as_many_as_the_state_counts_in_order_and_a_capacity_too_small_is_told) {
    World world = block();
    world.step(40);
    const talus_state s = world.state();
    const auto labels = contacts<int64_t>(world, TALUS_CONTACT_LABELS, 2);
    ASSERT_EQ(static_cast<int64_t>(labels.size()) / 2, s.contacts + s.wall_contacts);
    for (std::size_t k = 2; k < labels.size(); k += 2) EXPECT_TRUE(std::pair(labels[k - 2], labels[k - 1]) < std::pair(labels[k], labels[k + 1]));
    const auto sliding = contacts<int32_t>(world, TALUS_CONTACT_SLIDING, 1);
    EXPECT_EQ(std::accumulate(sliding.begin(), sliding.end(), int64_t{0}), s.sliding_contacts);
    double small[3];
    int64_t n = 0;
    EXPECT_EQ(talus_contacts_copy(world.handle(), TALUS_CONTACT_FORCE, 1, small, &n), TALUS_ERR_ARGUMENT);
    EXPECT_EQ(n, s.contacts + s.wall_contacts);
    EXPECT_EQ(talus_contacts_copy(world.handle(), 99, 0, nullptr, &n), TALUS_ERR_ARGUMENT);
    EXPECT_EQ(talus_contacts_copy(world.handle(), TALUS_CONTACT_FORCE, 5, nullptr, &n), TALUS_ERR_ARGUMENT);
    EXPECT_EQ(talus_contacts_copy(world.handle(), TALUS_CONTACT_FORCE, -1, small, &n), TALUS_ERR_ARGUMENT);
}

TEST(Removal, takes_grains_out_of_a_box_and_by_label_and_refuses_a_label_that_nobody_has) {
    World world = block();
    world.step(10);
    const int64_t all = world.state().particles;
    int64_t removed = -1;
    const std::vector<int64_t> labels{3, 17, 3, 100};
    world.check(talus_particles_remove(world.handle(), 4, labels.data(), &removed));
    EXPECT_EQ(removed, 3);
    EXPECT_EQ(world.state().particles, all - 3);
    for (const int64_t label : contacts<int64_t>(world, TALUS_CONTACT_LABELS, 2)) EXPECT_TRUE(label != 3 && label != 17 && label != 100);
    EXPECT_EQ(talus_particles_remove(world.handle(), 4, labels.data(), &removed), TALUS_ERR_ARGUMENT);
    EXPECT_NE(std::string(talus_engine_message(world.handle())).find("label 3"), std::string::npos);
    EXPECT_EQ(world.state().particles, all - 3);
    world.check(talus_particles_remove(world.handle(), 0, nullptr, &removed));
    EXPECT_EQ(removed, 0);

    const std::vector<double> x = copy(world, TALUS_FIELD_POSITION, 3);
    const double d = 2 * kSceneRadius, lo[3] = {0, 0, 0}, hi[3] = {3 * d, 2 * d, 2 * d};
    int64_t inside = 0;
    for (std::size_t k = 0; k < x.size(); k += 3) inside += x[k] >= lo[0] && x[k] < hi[0] && x[k + 1] >= lo[1] && x[k + 1] < hi[1] && x[k + 2] >= lo[2] && x[k + 2] < hi[2] ? 1 : 0;
    ASSERT_GT(inside, 0);
    world.check(talus_particles_remove_box(world.handle(), lo, hi, &removed));
    EXPECT_EQ(removed, inside);
    EXPECT_EQ(talus_particles_remove_box(world.handle(), hi, lo, &removed), TALUS_ERR_ARGUMENT);
    world.step(10);
    EXPECT_EQ(world.state().particles, all - 3 - inside);
}

TEST(Stepping, to_a_time_ends_there_or_less_than_a_step_later_and_not_at_all_in_the_past) {
    World world = block();
    world.step(3);
    const talus_state at = world.state();
    const double dt = at.time / 3.0;
    int64_t done = -1;
    world.check(talus_engine_advance_to(world.handle(), at.time + 10.0 * dt, &done));
    EXPECT_EQ(done, 10);
    world.check(talus_engine_advance_to(world.handle(), at.time + 12.5 * dt, &done));
    EXPECT_EQ(done, 3);
    world.check(talus_engine_advance_to(world.handle(), at.time, &done));
    EXPECT_EQ(done, 0);
    EXPECT_EQ(talus_engine_advance_to(world.handle(), std::nan(""), &done), TALUS_ERR_ARGUMENT);
    EXPECT_EQ(world.state().step, 16);
}

TEST(Memory, is_told_by_category_and_adds_up_to_what_the_state_says_a_grain_takes) {
    World world = block();
    world.step(20);
    talus_memory m;
    talus_memory_init(&m);
    world.check(talus_engine_memory(world.handle(), &m));
    for (const int64_t bytes : {m.records, m.cells, m.sums, m.pairs, m.histories}) EXPECT_GT(bytes, 0);
    const talus_state s = world.state();
    EXPECT_NEAR(static_cast<double>(m.records + m.cells + m.sums + m.pairs + m.histories + m.rebuild) / static_cast<double>(s.particles), s.bytes_per_particle, 1e-9 * s.bytes_per_particle);
}

} // namespace
} // namespace talus::test
