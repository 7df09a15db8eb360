// Damaged, foreign and impossible checkpoints, and writes that fail: refused by name, nothing lost.
#include "tests/support/checkpoint_case.hpp"

namespace talus::runtime {
namespace {

TEST_F(CheckpointTest, any_changed_byte_is_refused) {
    State before;
    before.fill();
    save_checkpoint(before.s, path_);
    const std::vector<char> whole = read_all(path_);
    std::mt19937_64 random(2);
    // All of the ends, and a sample of the rest.
    std::vector<std::size_t> places;
    for (std::size_t k = 0; k < 128; ++k) places.insert(places.end(), {k, whole.size() - 1 - k});
    for (int k = 0; k < 500; ++k) places.push_back(random() % whole.size());
    const std::string damaged = folder_ / "damaged.hdf";
    write_all(damaged, whole);
    for (const std::size_t at : places) {
        std::vector<char> byte{static_cast<char>(whole[at] ^ (1 << random() % 8))};
        const DiskFile file = DiskFile::open_to_write(damaged);
        file.write(at, byte.data(), 1);
        const std::string message = refusal(damaged);
        EXPECT_EQ(message.rfind(damaged, 0), 0u) << "byte " << at << " of " << whole.size() << ": " << message;
        file.write(at, &whole[at], 1);
    }
    EXPECT_EQ(refusal(damaged), "");
}

TEST_F(CheckpointTest, damage_is_named) {
    State before;
    before.fill();
    save_checkpoint(before.s, path_);
    FileImage image;
    const Seal seal = read_seal(DiskFile::open_to_read(path_), image);
    for (const char* name : {"/grains/velocity", "/contacts/number", "/contacts/history", "/VTKHDF/Types"}) {
        const std::uint64_t at = seal.find(name)->place.offset + 8;
        const DiskFile file = DiskFile::open_to_write(path_);
        char old, damaged;
        file.read(at, &old, 1);
        damaged = static_cast<char>(old ^ 1);
        file.write(at, &damaged, 1);
        EXPECT_NE(refusal(path_).find(std::string("the bytes of dataset ") + name + " do not give the stored digest"), std::string::npos) << refusal(path_);
        file.write(at, &old, 1);
    }
}

TEST_F(CheckpointTest, cut_or_extended_files_are_refused) {
    State before;
    before.fill();
    save_checkpoint(before.s, path_);
    const std::vector<char> whole = read_all(path_);
    const std::string other = folder_ / "cut.hdf";
    for (const std::size_t n : {std::size_t{0}, std::size_t{1}, std::size_t{63}, std::size_t{64}, std::size_t{4096}, whole.size() / 2, whole.size() - 64, whole.size() - 1}) {
        write_all(other, std::vector<char>(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(n)));
        EXPECT_NE(refusal(other), "") << n << " bytes";
    }
    EXPECT_NE(refusal(other).find("commit record at its end is missing"), std::string::npos) << refusal(other);
    std::vector<char> longer = whole;
    longer.push_back('\0');
    write_all(other, longer);
    EXPECT_NE(refusal(other), "");
    // A piece taken out: the trailer is whole, the length is not.
    std::vector<char> shorter = whole;
    shorter.erase(shorter.begin() + 5000, shorter.begin() + 9096);
    write_all(other, shorter);
    EXPECT_NE(refusal(other).find("file's length"), std::string::npos);
}

TEST_F(CheckpointTest, foreign_and_missing_files_are_refused_by_name) {
    EXPECT_EQ(refusal(path_), path_ + ": cannot be opened: No such file or directory");
    write_all(path_, std::vector<char>(10000, 'x'));
    EXPECT_EQ(refusal(path_), path_ + ": is not a checkpoint of Talus");
    EXPECT_EQ(refusal(folder_), folder_.string() + ": is not a regular file");
    State state;
    state.fill();
    write_snapshot(state.s, path_);
    EXPECT_NE(refusal(path_).find("is another kind of HDF5 file"), std::string::npos);
    fs::rename(path_, path_ + ".previous");
    EXPECT_NE(refusal(path_).find(". The checkpoint before it is " + path_ + ".previous"), std::string::npos);
}

/// A file-size limit that ends every write beyond it, as a full disk does.
class SizeLimit {
public:
    explicit SizeLimit(rlim_t bytes) {
        getrlimit(RLIMIT_FSIZE, &old_);
        before_ = std::signal(SIGXFSZ, SIG_IGN);
        const rlimit limit{bytes, old_.rlim_max};
        setrlimit(RLIMIT_FSIZE, &limit);
    }
    ~SizeLimit() {
        setrlimit(RLIMIT_FSIZE, &old_);
        std::signal(SIGXFSZ, before_);
    }

private:
    rlimit old_;
    void (*before_)(int);
};

TEST_F(CheckpointTest, a_failed_write_is_an_error_and_leaves_the_old_file) {
    State state;
    state.fill();
    save_checkpoint(state.s, path_);
    const std::vector<char> old = read_all(path_);
    const std::string picture = folder_ / "picture.hdf";
    state.s.model.step += 1;
    for (rlim_t limit = 0; limit < old.size(); limit += 3000) {
        std::string saved, drawn;
        testing::internal::CaptureStderr();
        {
            const SizeLimit full(limit);
            try {
                save_checkpoint(state.s, path_);
            } catch (const core::Error& e) {
                saved = e.what();
            }
            if (limit < 20000) { // a picture is smaller
                try {
                    write_snapshot(state.s, picture);
                } catch (const core::Error& e) {
                    drawn = e.what();
                }
            }
        }
        EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
        EXPECT_NE(saved.find("File too large"), std::string::npos) << limit << " " << saved;
        if (limit < 20000) {
            EXPECT_NE(drawn.find("File too large"), std::string::npos) << limit << " " << drawn;
        }
        EXPECT_TRUE(old == read_all(path_));
        EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1);
    }
    save_checkpoint(state.s, path_); // and the next one succeeds
    EXPECT_EQ(refusal(path_), "");
    EXPECT_NE(refusal(folder_ / "absent" / "state.hdf"), "");
}

TEST_F(CheckpointTest, states_that_cannot_be_are_refused) {
    const auto message_after = [&](auto spoil) {
        State state;
        state.fill();
        spoil(state.s);
        save_checkpoint(state.s, path_);
        fs::remove(path_ + ".previous");
        return refusal(path_);
    };
    EXPECT_EQ(message_after([](EngineState&) {}), "");
    EXPECT_NE(message_after([](EngineState& s) { s.sub.particles[5].velocity[1] = NAN; }).find("grain 1005 has a number that is not finite"), std::string::npos);
    EXPECT_NE(message_after([](EngineState& s) { s.sub.particles[5].radius = 2.0; }).find("grain 1005 has the radius 2 m"), std::string::npos);
    EXPECT_NE(message_after([](EngineState& s) { s.sub.particles[5].meta = core::make_meta(9, 0, 0); }).find("grain 1005 has material 9"), std::string::npos);
    EXPECT_NE(message_after([](EngineState& s) {
                  for (const Label partner : {1L, 2L}) s.sub.particles.push_back(s.sub.particles[static_cast<std::size_t>(partner)]);
                  s.sub.n_owned += 2;
                  s.model.n_particles += 2;
                  for (int k = 0; k < 2; ++k) {
                      s.sub.references.push_back({});
                      s.sub.sums.push_back({});
                      s.sub.slot_of.push_back(s.sub.contacts.append(nullptr, nullptr, 0));
                  }
              }).find("two grains have the label 1001"),
              std::string::npos);
    EXPECT_NE(message_after([](EngineState& s) { s.sub.contacts.rows[12] += 1.0; }).find("differ between its two grains"), std::string::npos);
    EXPECT_NE(message_after([](EngineState& s) { s.sub.contacts.partners[0] = 999999; }).find("differ between its two grains"), std::string::npos);
    EXPECT_NE(message_after([](EngineState& s) { s.sub.contacts.partners[0] = core::kWallLabel + 2; }).find("which does not exist"), std::string::npos);
    EXPECT_NE(message_after([](EngineState& s) { s.model.n_particles -= 1; }).find("it holds 216 grains, but says 215"), std::string::npos);
    EXPECT_NE(message_after([](EngineState& s) { s.model.units.force.unit = 0.3; }).find("powers of two"), std::string::npos);
    EXPECT_NE(message_after([](EngineState& s) { s.model.settings.time_step = -1.0; }).find("time_step = -1"), std::string::npos);
    EXPECT_NE(message_after([](EngineState& s) { s.model.settings.laws.normal = static_cast<core::NormalLaw>(7); }).find("laws.normal = 7"), std::string::npos);
    EXPECT_NE(message_after([](EngineState& s) { s.model.walls[0].plane.material = 3; }).find("wall 0 has material 3 of 3"), std::string::npos);
}

} // namespace
} // namespace talus::runtime
