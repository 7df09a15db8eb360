// ranks: 1 2 3
// What is observed of contacts (stress, unbalanced force, energies) has the same bits on any ranks: contacts across subdomains are seen
// with the velocities that both grains have now.
#include <algorithm>

#include "../support/determinism.hpp"
#include "../support/sheared_block.hpp"

namespace talus::test {
namespace {

constexpr int64_t kSteps = 40;

struct Seen {
    double stress[9], solid_fraction, coordination, unbalanced, elastic;
};

Seen look(World& world) {
    Seen seen{};
    const double lo[3] = {0, 0, 0}, hi[3] = {8 * kSceneRadius, 8 * kSceneRadius, 8 * kSceneRadius};
    world.check(talus_engine_stress(world.handle(), lo, hi, seen.stress, &seen.solid_fraction, &seen.coordination));
    seen.unbalanced = world.state().unbalanced_force;
    talus_energy energy;
    talus_energy_init(&energy);
    world.check(talus_engine_energy(world.handle(), &energy));
    seen.elastic = energy.elastic_normal + energy.elastic_tangential;
    return seen;
}

TEST(Observation, has_the_same_bits_on_any_ranks) {
    Seen serial{};
    if (world_rank_of_me() == 0) {
        World world = make_sheared_block({12, 6, 10}, 0.5, HowToRun{});
        world.step(kSteps);
        serial = look(world);
    }
    MPI_Bcast(&serial, sizeof serial, MPI_BYTE, 0, MPI_COMM_WORLD);
    HowToRun run = parallel_run();
    World world = make_sheared_block({12, 6, 10}, 0.5, run);
    world.step(kSteps);
    const Seen seen = look(world);
    for (int k = 0; k < 9; ++k) EXPECT_EQ(seen.stress[k], serial.stress[k]) << "component " << k;
    EXPECT_EQ(seen.solid_fraction, serial.solid_fraction);
    EXPECT_EQ(seen.coordination, serial.coordination);
    EXPECT_EQ(seen.unbalanced, serial.unbalanced);
    EXPECT_EQ(seen.elastic, serial.elastic);
    EXPECT_GT(serial.unbalanced, 0.0);
}

/// Labels and forces of all contacts, on rank 0, by labels.
std::vector<std::pair<std::array<int64_t, 2>, std::array<double, 3>>> all_contacts(World& world) {
    int64_t n = 0;
    world.check(talus_contacts_copy(world.handle(), TALUS_CONTACT_LABELS, 0, nullptr, &n));
    std::vector<std::array<int64_t, 2>> labels(static_cast<std::size_t>(n) + 1);
    std::vector<std::array<double, 3>> force(labels.size());
    world.check(talus_contacts_copy(world.handle(), TALUS_CONTACT_LABELS, n + 1, labels.data(), &n));
    world.check(talus_contacts_copy(world.handle(), TALUS_CONTACT_FORCE, n + 1, force.data(), &n));
    std::vector<std::pair<std::array<int64_t, 2>, std::array<double, 3>>> all;
    for (std::size_t k = 0; k < static_cast<std::size_t>(n); ++k) all.push_back({labels[k], force[k]});
    if (world.ranks() == 1) return all;
    int mine = static_cast<int>(all.size() * sizeof all[0]);
    std::vector<int> bytes(static_cast<std::size_t>(world.ranks())), at(bytes.size() + 1, 0);
    MPI_Allgather(&mine, 1, MPI_INT, bytes.data(), 1, MPI_INT, MPI_COMM_WORLD);
    for (std::size_t r = 0; r < bytes.size(); ++r) at[r + 1] = at[r] + bytes[r];
    auto sum = all;
    sum.resize(static_cast<std::size_t>(at.back()) / sizeof all[0]);
    MPI_Gatherv(all.data(), mine, MPI_BYTE, sum.data(), bytes.data(), at.data(), MPI_BYTE, 0, MPI_COMM_WORLD);
    std::sort(sum.begin(), sum.end());
    return sum;
}

TEST(Observation, contacts_and_their_forces_are_the_same_on_any_ranks) {
    World world = make_sheared_block({12, 6, 10}, 0.5, parallel_run());
    world.step(kSteps);
    const auto seen = all_contacts(world);
    if (world_rank_of_me() != 0) return;
    World serial = make_sheared_block({12, 6, 10}, 0.5, HowToRun{});
    serial.step(kSteps);
    const auto expected = all_contacts(serial);
    EXPECT_GT(expected.size(), 1000u);
    EXPECT_EQ(seen, expected);
}

} // namespace
} // namespace talus::test
