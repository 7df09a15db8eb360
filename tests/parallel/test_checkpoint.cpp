// ranks: 1 2 3 4
// timeout: 240
// A run that is saved and resumed, on as many ranks or on others, is the run that was never interrupted.
#include <unistd.h>

#include <filesystem>

#include "../support/determinism.hpp"

namespace talus::test {
namespace {

/// A folder that rank 0 makes and removes, the same on every rank.
class SharedFolder {
public:
    SharedFolder() {
        char name[512] = {};
        if (world_rank_of_me() == 0) {
            const auto path = std::filesystem::temp_directory_path() / ("talus-test-" + std::to_string(getpid()));
            std::filesystem::create_directories(path);
            std::snprintf(name, sizeof name, "%s", path.c_str());
        }
        MPI_Bcast(name, sizeof name, MPI_CHAR, 0, MPI_COMM_WORLD);
        path_ = name;
    }
    ~SharedFolder() {
        MPI_Barrier(MPI_COMM_WORLD);
        std::error_code ignored;
        if (world_rank_of_me() == 0) std::filesystem::remove_all(path_, ignored);
    }
    std::string operator/(const char* file) const { return path_ + "/" + file; }

private:
    std::string path_;
};

World load(const std::string& path, const HowToRun& run) {
    talus_settings s;
    talus_settings_init(&s);
    s.threads = run.threads;
    s.rebalance = run.rebalance;
    s.skin = run.skin * 2.0 * kSceneRadius;
    s.tile_grains = run.tile_grains;
    talus_engine* engine = nullptr;
    const talus_status status = talus_checkpoint_load(path.c_str(), &s, run.comm, &engine);
    if (status != TALUS_OK) throw TalusError(status, talus_message());
    return World(engine);
}

void save(World& world, const std::string& path) { world.check(talus_checkpoint_save(world.handle(), path.c_str())); }

constexpr int64_t kSteps = 200, kBefore = 70;

TEST(Checkpoint, saved_and_resumed_on_the_same_ranks_ends_with_the_bits_of_the_undisturbed_run) {
    const SharedFolder folder;
    for (const Scene& scene : {kShear, kPour, kPeriodic, kGas}) {
        SCOPED_TRACE(scene.name);
        const std::string path = folder / scene.name;
        const talus_state reference = serial_reference(scene, kSteps);
        talus_state at_save;
        {
            World world = scene.make(parallel_run());
            scene.advance(world, 0, kBefore, kSteps);
            at_save = world.state();
            save(world, path);
            EXPECT_EQ(digest_of(world.state()), digest_of(at_save)) << "saving changes nothing";
            scene.advance(world, kBefore, kSteps, kSteps);
            EXPECT_EQ(digest_of(world.state()), digest_of(reference)) << "nor what comes after";
        }
        HowToRun other = parallel_run();
        other.threads = 1;
        other.skin = 0.17;
        other.tile_grains = 300;
        World world = load(path, other);
        EXPECT_EQ(digest_of(world.state()), digest_of(at_save));
        EXPECT_EQ(world.state().step, kBefore);
        EXPECT_EQ(world.state().contacts, at_save.contacts);
        scene.advance(world, kBefore, kSteps, kSteps);
        EXPECT_EQ(digest_of(world.state()), digest_of(reference));
    }
}

TEST(Checkpoint, saved_over_all_ranks_and_resumed_by_a_serial_engine_goes_on_with_the_same_bits) {
    const SharedFolder folder;
    const std::string path = folder / "state";
    const talus_state reference = serial_reference(kShear, kSteps);
    World world = make_shear(parallel_run());
    world.step(kBefore);
    save(world, path);
    if (world.rank() == 0) {
        World serial = load(path, HowToRun{});
        serial.step(kSteps - kBefore);
        EXPECT_EQ(digest_of(serial.state()), digest_of(reference));
    }
}

TEST(Checkpoint, saved_by_a_serial_engine_and_resumed_over_all_ranks_or_some_goes_on_with_the_same_bits) {
    const SharedFolder folder;
    const std::string path = folder / "state";
    const talus_state reference = serial_reference(kPeriodic, kSteps);
    if (world_rank_of_me() == 0) {
        World serial = make_periodic(HowToRun{});
        serial.step(kBefore);
        save(serial, path);
    }
    MPI_Barrier(MPI_COMM_WORLD);
    {
        World world = load(path, parallel_run());
        world.step(kSteps - kBefore);
        EXPECT_EQ(digest_of(world.state()), digest_of(reference));
    }
    // All but the last rank.
    const int some = std::max(1, world_size() - 1);
    MPI_Comm comm;
    MPI_Comm_split(MPI_COMM_WORLD, world_rank_of_me() < some ? 0 : 1, world_rank_of_me(), &comm);
    if (world_rank_of_me() < some) {
        HowToRun run = parallel_run();
        run.comm = MPI_Comm_c2f(comm);
        World world = load(path, run);
        EXPECT_EQ(world.ranks(), some);
        world.step(kSteps - kBefore);
        EXPECT_EQ(digest_of(world.state()), digest_of(reference));
    }
    MPI_Comm_free(&comm);
}

TEST(Checkpoint, a_chain_of_many_saves_and_loads_ends_with_the_bits_of_the_undisturbed_run) {
    const SharedFolder folder;
    const std::string path = folder / "state";
    const talus_state reference = serial_reference(kShear, 100);
    {
        World world = make_shear(parallel_run());
        world.step(7);
        save(world, path);
    }
    for (const int64_t until : {8, 30, 31, 60, 100}) {
        World world = load(path, parallel_run());
        world.step(until - world.state().step);
        save(world, path);
    }
    World world = load(path, parallel_run());
    EXPECT_EQ(digest_of(world.state()), digest_of(reference));
}

TEST(Checkpoint, a_missing_file_is_the_same_error_on_every_rank) {
    const SharedFolder folder;
    talus_settings s;
    talus_settings_init(&s);
    talus_engine* engine = nullptr;
    EXPECT_EQ(talus_checkpoint_load((folder / "nowhere").c_str(), &s, world_handle(), &engine), TALUS_ERR_IO);
    EXPECT_EQ(engine, nullptr);
    EXPECT_NE(std::string(talus_message()).find("nowhere"), std::string::npos);
}

TEST(Checkpoint, a_folder_that_does_not_exist_is_the_same_error_on_every_rank_and_the_engine_goes_on) {
    const SharedFolder folder;
    const talus_state reference = serial_reference(kGas, 60);
    World world = make_gas(parallel_run());
    world.step(30);
    EXPECT_EQ(talus_checkpoint_save(world.handle(), (folder / "no/such/folder/state").c_str()), TALUS_ERR_IO);
    world.step(30);
    EXPECT_EQ(digest_of(world.state()), digest_of(reference));
}

} // namespace
} // namespace talus::test
