// Checkpoints and snapshots without an engine: what is written comes back, and opens elsewhere.
#include "tests/support/checkpoint_case.hpp"

namespace talus::runtime {
namespace {

TEST_F(CheckpointTest, state_comes_back_bit_for_bit) {
    State before;
    before.fill();
    save_checkpoint(before.s, path_);
    Settings other = settings(); // what is not physics stays the caller's, the rest is the file's
    other.threads = 2;
    other.skin = 0.25;
    other.seed = 1;
    other.gravity[1] = 0.0;
    other.laws.rolling = core::RollingLaw::none;
    other.domain.hi[0] = 100.0;
    State after(other);
    load_checkpoint(after.s, path_);
    expect_equal(before.s, after.s);
    EXPECT_EQ(after.s.model.settings.threads, 2);
    EXPECT_EQ(after.s.model.settings.skin, 0.25);
    EXPECT_EQ(content_of(after.s).contacts.size(), std::size_t{2 * 3 * kSide * kSide * (kSide - 1) + kSide * kSide});
}

TEST_F(CheckpointTest, state_in_tiles_comes_back_and_the_file_does_not_depend_on_threads) {
    std::vector<char> first;
    for (const int threads : {1, 3}) {
        Settings set = settings();
        set.threads = threads;
        State before(set);
        before.fill();
        rebuild(before.s, true, true);
        ASSERT_FALSE(before.s.sub.laid_out);
        ASSERT_GT(before.s.sub.tiles.size(), 1u);
        before.s.sub.tiles.back().heat.friction = 4;
        before.s.sub.heat.friction -= 4;
        const std::size_t particles = before.s.sub.particles.size();
        save_checkpoint(before.s, path_);
        EXPECT_FALSE(before.s.sub.laid_out); // saving changes nothing
        EXPECT_EQ(before.s.sub.particles.size(), particles);
        State after;
        load_checkpoint(after.s, path_);
        rebuild(after.s, true, true);
        empty_tiles(before.s, true);
        expect_equal(before.s, after.s);
        if (first.empty()) first = read_all(path_);
        EXPECT_TRUE(first == read_all(path_));
    }
}

TEST_F(CheckpointTest, laws_without_history_and_states_without_walls_or_grains_come_back) {
    Settings set = settings();
    set.laws.rolling = core::RollingLaw::none;
    set.laws.tangential = core::TangentialLaw::none;
    State before(set);
    before.fill();
    save_checkpoint(before.s, path_);
    State after;
    load_checkpoint(after.s, path_);
    expect_equal(before.s, after.s);

    State bare(set);
    bare.s.sub.contacts.first.assign(1, 0);
    bare.s.sub.laid_out = true;
    save_checkpoint(bare.s, path_);
    State bare_again;
    load_checkpoint(bare_again.s, path_);
    EXPECT_EQ(bare_again.s.sub.n_owned, 0u);
}

TEST_F(CheckpointTest, two_generations_are_kept_and_both_load) {
    State state;
    state.fill();
    for (const std::int64_t step : {1, 2, 3}) {
        state.s.model.step = step;
        save_checkpoint(state.s, path_);
    }
    State now, before;
    load_checkpoint(now.s, path_);
    load_checkpoint(before.s, path_ + ".previous");
    EXPECT_EQ(now.s.model.step, 3);
    EXPECT_EQ(before.s.model.step, 2);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 2);
    // A damaged end does not push out the whole one before it.
    fs::resize_file(path_, fs::file_size(path_) - 1);
    state.s.model.step = 4;
    save_checkpoint(state.s, path_);
    State again;
    load_checkpoint(again.s, path_ + ".previous");
    EXPECT_EQ(again.s.model.step, 2);
}

TEST_F(CheckpointTest, pictures_and_checkpoints_have_what_paraview_reads) {
    State state;
    state.fill();
    write_snapshot(state.s, folder_ / "picture.hdf");
    save_checkpoint(state.s, path_);
    for (const std::string& file : {(folder_ / "picture.hdf").string(), path_}) {
        const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
        ASSERT_GE(id, 0);
        const hid_t type = H5Aopen_by_name(id, "/VTKHDF", "Type", H5P_DEFAULT, H5P_DEFAULT), text = H5Aget_type(type);
        EXPECT_EQ(H5Tget_size(text), 16u);
        char name[17] = {};
        H5Aread(type, text, name);
        EXPECT_STREQ(name, "UnstructuredGrid");
        for (const char* set : {"/VTKHDF/Points", "/VTKHDF/PointData/label", "/VTKHDF/PointData/radius", "/VTKHDF/PointData/velocity", "/VTKHDF/PointData/colour", "/VTKHDF/Connectivity", "/VTKHDF/Offsets", "/VTKHDF/Types", "/VTKHDF/FieldData/TimeValue"}) {
            const hid_t opened = H5Dopen2(id, set, H5P_DEFAULT);
            EXPECT_GE(opened, 0) << set;
            if (opened >= 0) H5Dclose(opened);
        }
        const hid_t points = H5Dopen2(id, "/VTKHDF/Points", H5P_DEFAULT);
        std::vector<double> x(3 * state.s.sub.n_owned);
        EXPECT_GE(H5Dread(points, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, x.data()), 0);
        for (std::size_t i = 0; i < state.s.sub.n_owned; ++i) EXPECT_EQ(std::memcmp(&x[3 * i], state.s.sub.particles[i].position, 24), 0);
        H5Dclose(points);
        H5Tclose(text);
        H5Aclose(type);
        H5Fclose(id);
    }
}

} // namespace
} // namespace talus::runtime
