// Checkpoints from inside: what is saved comes back bit for bit; what is damaged, cut, foreign or unfinished is refused; a write
// that fails leaves what was there.
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>

#include <gtest/gtest.h>
#include <hdf5.h>
#include <sys/resource.h>
#include <unistd.h>

#include "runtime/io/checkpoint.hpp"
#include "runtime/io/seal.hpp"
#include "runtime/io/snapshot.hpp"
#include "runtime/phase/phases.hpp"

namespace talus::runtime {
namespace {

namespace fs = std::filesystem;
using core::Label;
using core::Particle;

constexpr int kSide = 6;                 // grains along an edge
constexpr double kRadius = 0.5, kStep = 0.98; // m: neighbours overlap
constexpr Label kFirstLabel = 1000;

Settings settings() {
    Settings s;
    for (int a = 0; a < 3; ++a) {
        s.domain.lo[a] = -1.0;
        s.domain.hi[a] = kSide + 1.0;
    }
    s.domain.periodic[2] = true;
    s.time_step = 1e-5 / 3.0;
    s.seed = ~std::uint64_t{5};
    s.energy_ledger = true;
    s.laws.rolling = core::RollingLaw::spring;
    s.tile_grains = 32;
    return s;
}

/// A state that a run could have had: every number is there to be lost.
class State {
public:
    explicit State(const Settings& set = settings()) : s(set, std::make_unique<Communicator>()) { s.slices = core::SliceGrid(set.domain, {1, 1, 1}); }

    void fill() {
        fill_model();
        std::mt19937_64 random(1);
        const auto any = [&] { return std::uniform_real_distribution<double>(-1.0, 1.0)(random); };
        std::map<std::pair<Label, Label>, std::array<core::Quad, 2>> rows;
        const auto row_of = [&](Label a, Label b) -> const core::Quad* {
            const auto [at, fresh] = rows.try_emplace({std::min(a, b), std::max(a, b)});
            if (fresh)
                for (core::Quad& q : at->second)
                    for (double& v : q.v) v = any();
            return at->second.data();
        };
        Subdomain& sub = s.sub;
        const int quads = core::history_doubles(s.model.settings.laws) / 4;
        sub.contacts.history_quads = quads;
        sub.contacts.first.assign(1, 0);
        const auto label_at = [](int x, int y, int z) { return kFirstLabel + (x * kSide + y) * kSide + z; };
        for (int x = 0; x < kSide; ++x)
            for (int y = 0; y < kSide; ++y)
                for (int z = 0; z < kSide; ++z) {
                    Particle p{};
                    p.label = label_at(x, y, z);
                    const int place[3] = {x, y, z};
                    core::Reference reference;
                    for (int a = 0; a < 3; ++a) {
                        p.position[a] = kStep * place[a] + 1e-3 * any();
                        p.velocity[a] = any();
                        p.angular_velocity[a] = any();
                        reference[a] = any();
                    }
                    p.radius = kRadius;
                    p.mass = 1.0 + 0.1 * any();
                    p.meta = core::make_meta(y == 0 ? 1 : 0, x, 7 * y);
                    core::ForceSum sum{};
                    for (int c = 0; c < 3; ++c) {
                        sum.force[c] = static_cast<std::int64_t>(random());
                        sum.torque[c] = static_cast<std::int64_t>(random());
                    }
                    std::vector<Label> partners;
                    const int steps[6][3] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
                    for (const auto& d : steps) {
                        const int q[3] = {x + d[0], y + d[1], z + d[2]};
                        if (std::all_of(q, q + 3, [](int c) { return c >= 0 && c < kSide; })) partners.push_back(label_at(q[0], q[1], q[2]));
                    }
                    if (y == 0) partners.push_back(core::kWallLabel + 1);
                    std::vector<core::Quad> of_grain;
                    for (const Label other : partners) of_grain.insert(of_grain.end(), row_of(p.label, other), row_of(p.label, other) + quads);
                    sub.particles.push_back(p);
                    sub.references.push_back(reference);
                    sub.sums.push_back(sum);
                    sub.slot_of.push_back(static_cast<std::uint32_t>(sub.slot_of.size()));
                    sub.contacts.append(partners.data(), of_grain.data(), static_cast<std::uint32_t>(partners.size()));
                }
        sub.n_owned = static_cast<core::LocalIndex>(sub.particles.size());
        sub.laid_out = true;
        s.model.n_particles = sub.n_owned;
        const core::Wide large = (static_cast<core::Wide>(3) << 70) + 5;
        sub.heat = {large, -large, 17};
        sub.wall_last.resize(2);
        sub.wall_impulse.assign(6, 0);
        for (int c = 0; c < 3; ++c) {
            sub.wall_last[1].force[c] = -large - c;
            sub.wall_last[0].torque[c] = large * (c + 1);
            sub.wall_impulse[3 + static_cast<std::size_t>(c)] = -c;
        }
        sub.wall_last[1].contacts = kSide * kSide;
    }

    EngineState s;

private:
    void fill_model() {
        Model& m = s.model;
        m.materials = {{1e7 / 3.0, 0.3, 2650.0, false}, {2e7, 0.25, 1000.0, false}, {INFINITY, 0.0, 0.0, true}};
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b) {
                m.contacts[a][b] = {0.4 + 0.01 * (a + b), 0.5 / 3.0, 0.1, true};
                s.force.pairs[a][b] = {1.0 / 3.0 + a + b, 2.0, 3.0, 4.0, 0.5, 0.1, 0.3, 0.0};
            }
        core::WallPlane floor;
        floor.point = {0.1, -kRadius, 0.3};
        floor.normal = {0.0, 1.0, 0.0};
        floor.velocity = {0.1, 0.0, 1.0 / 7.0};
        floor.material = 2;
        core::WallPlane side = floor;
        side.point.x = -0.9;
        side.normal = {0.6, 0.8, 0.0};
        m.walls = {{side, {}, -1.25}, {floor, {}, 1.0 / 3.0}};
        m.groups[3].mode = core::GroupMotion::Mode::driven;
        m.groups[3].velocity[1] = 0.1;
        m.step = 123456789012;
        m.time = 1.0 / 3.0;
        m.radius_max = m.radius_min = kRadius;
        m.units = core::FixedUnits::make(1e6, kRadius, kSide + 1.0);
        m.units_fixed = true;
    }
};

/// All that must come back, in an order of its own: grains and contacts by label.
struct Content {
    std::map<Label, std::vector<std::byte>> grains;
    std::map<std::pair<Label, Label>, std::vector<std::byte>> contacts;
    bool operator==(const Content&) const = default;
};

std::vector<std::byte> bytes_of(std::initializer_list<std::pair<const void*, std::size_t>> pieces) {
    std::vector<std::byte> out;
    for (const auto& [data, n] : pieces) out.insert(out.end(), static_cast<const std::byte*>(data), static_cast<const std::byte*>(data) + n);
    return out;
}

Content content_of(EngineState& s) {
    Content c;
    if (!s.sub.laid_out) empty_tiles(s);
    const Subdomain& sub = s.sub;
    for (core::LocalIndex i = 0; i < sub.n_owned; ++i) {
        const Particle& p = sub.particles[i];
        c.grains[p.label] = bytes_of({{p.position, 96}, {sub.references[i].data(), 24}, {sub.sums[i].force, 24}, {sub.sums[i].torque, 24}});
        const std::uint32_t slot = sub.slot_of[i];
        for (std::uint32_t e = sub.contacts.first[slot]; e < sub.contacts.first[slot + 1]; ++e)
            c.contacts[{p.label, sub.contacts.entries[e].partner}] = bytes_of({{sub.contacts.row(sub.contacts.entries[e]), sizeof(core::Quad) * static_cast<std::size_t>(sub.contacts.history_quads)}});
    }
    return c;
}

class CheckpointTest : public testing::Test {
protected:
    void SetUp() override {
        folder_ = fs::temp_directory_path() / ("talus_checkpoint_" + std::to_string(::getpid()));
        fs::create_directories(folder_);
        path_ = folder_ / "state.hdf";
    }
    void TearDown() override { fs::remove_all(folder_); }

    static std::vector<char> read_all(const std::string& path) {
        std::ifstream in(path, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    static void write_all(const std::string& path, const std::vector<char>& bytes) {
        std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    }
    /// The message with which a load is refused; the state that was to take it must be untouched.
    static std::string refusal(const std::string& path) {
        State fresh;
        try {
            load_checkpoint(fresh.s, path);
        } catch (const core::Error& e) {
            EXPECT_EQ(e.kind(), core::ErrorKind::io) << e.what();
            EXPECT_TRUE(fresh.s.sub.particles.empty());
            EXPECT_EQ(fresh.s.model.n_particles, 0);
            return e.what();
        }
        return {};
    }

    fs::path folder_;
    std::string path_;
};

void expect_equal(EngineState& a, EngineState& b) {
    EXPECT_EQ(content_of(a), content_of(b));
    const Model &m = a.model, &n = b.model;
    EXPECT_EQ(m.step, n.step);
    EXPECT_EQ(m.time, n.time);
    EXPECT_EQ(m.n_particles, n.n_particles);
    EXPECT_EQ(m.radius_max, n.radius_max);
    EXPECT_EQ(m.units_fixed, n.units_fixed);
    for (const auto unit : {&core::FixedUnits::force, &core::FixedUnits::torque, &core::FixedUnits::wall_torque}) {
        EXPECT_EQ((m.units.*unit).unit, (n.units.*unit).unit);
        EXPECT_EQ((m.units.*unit).scale, (n.units.*unit).scale);
    }
    const core::Laws &l = m.settings.laws, &k = n.settings.laws;
    EXPECT_TRUE(l.normal == k.normal && l.damping == k.damping && l.tangential == k.tangential && l.rolling == k.rolling && l.rolling_radius == k.rolling_radius && l.tangential_damping == k.tangential_damping);
    EXPECT_TRUE(l.rolling_rate == k.rolling_rate && l.rolling_damping == k.rolling_damping && l.stiffness_n == k.stiffness_n && l.stiffness_t == k.stiffness_t);
    EXPECT_EQ(std::memcmp(m.settings.gravity, n.settings.gravity, sizeof m.settings.gravity), 0);
    EXPECT_EQ(m.settings.seed, n.settings.seed);
    EXPECT_EQ(m.settings.time_step, n.settings.time_step);
    EXPECT_EQ(m.settings.energy_ledger, n.settings.energy_ledger);
    for (int k = 0; k < 3; ++k) {
        EXPECT_EQ(m.settings.domain.lo[k], n.settings.domain.lo[k]);
        EXPECT_EQ(m.settings.domain.hi[k], n.settings.domain.hi[k]);
        EXPECT_EQ(m.settings.domain.periodic[k], n.settings.domain.periodic[k]);
    }
    ASSERT_EQ(m.materials.size(), n.materials.size());
    for (std::size_t k = 0; k < m.materials.size(); ++k) {
        EXPECT_EQ(m.materials[k].young, n.materials[k].young);
        EXPECT_EQ(m.materials[k].poisson, n.materials[k].poisson);
        EXPECT_EQ(m.materials[k].density, n.materials[k].density);
        EXPECT_EQ(m.materials[k].rigid, n.materials[k].rigid);
        for (std::size_t j = 0; j < m.materials.size(); ++j) {
            EXPECT_EQ(m.contacts[k][j].restitution, n.contacts[k][j].restitution);
            EXPECT_EQ(m.contacts[k][j].friction, n.contacts[k][j].friction);
            EXPECT_EQ(m.contacts[k][j].is_set, n.contacts[k][j].is_set);
            EXPECT_EQ(std::memcmp(&a.force.pairs[k][j], &b.force.pairs[k][j], sizeof a.force.pairs[k][j]), 0);
        }
    }
    ASSERT_EQ(m.walls.size(), n.walls.size());
    for (std::size_t w = 0; w < m.walls.size(); ++w) {
        const core::WallPlane &p = m.walls[w].plane, &q = n.walls[w].plane;
        EXPECT_EQ(std::memcmp(&p.point, &q.point, 3 * sizeof p.point), 0);
        EXPECT_EQ(p.material, q.material);
        EXPECT_EQ(m.walls[w].work, n.walls[w].work);
        EXPECT_EQ(a.sub.wall_last[w].contacts, b.sub.wall_last[w].contacts);
        for (int c = 0; c < 3; ++c) {
            EXPECT_TRUE(a.sub.wall_last[w].force[c] == b.sub.wall_last[w].force[c]);
            EXPECT_TRUE(a.sub.wall_last[w].torque[c] == b.sub.wall_last[w].torque[c]);
            EXPECT_TRUE(a.sub.wall_impulse[3 * w + static_cast<std::size_t>(c)] == b.sub.wall_impulse[3 * w + static_cast<std::size_t>(c)]);
        }
    }
    EXPECT_TRUE(a.sub.heat.friction == b.sub.heat.friction && a.sub.heat.damping == b.sub.heat.damping && a.sub.heat.rolling == b.sub.heat.rolling);
    for (std::size_t g = 0; g < m.groups.size(); ++g) {
        EXPECT_EQ(m.groups[g].mode, n.groups[g].mode);
        EXPECT_EQ(std::memcmp(m.groups[g].velocity, n.groups[g].velocity, sizeof m.groups[g].velocity), 0);
    }
}

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
        rebuild(before.s, true);
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
        rebuild(after.s, true);
        empty_tiles(before.s);
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
                      s.sub.slot_of.push_back(static_cast<std::uint32_t>(s.sub.contacts.first.size() - 1));
                      s.sub.contacts.append(nullptr, nullptr, 0);
                  }
              }).find("two grains have the label 1001"),
              std::string::npos);
    EXPECT_NE(message_after([](EngineState& s) { s.sub.contacts.rows[3].v[0] += 1.0; }).find("differ between its two grains"), std::string::npos);
    EXPECT_NE(message_after([](EngineState& s) { s.sub.contacts.entries[0].partner = 999999; }).find("differ between its two grains"), std::string::npos);
    EXPECT_NE(message_after([](EngineState& s) { s.sub.contacts.entries[0].partner = core::kWallLabel + 2; }).find("which does not exist"), std::string::npos);
    EXPECT_NE(message_after([](EngineState& s) { s.model.n_particles -= 1; }).find("it holds 216 grains, but says 215"), std::string::npos);
    EXPECT_NE(message_after([](EngineState& s) { s.model.units.force.unit = 0.3; }).find("powers of two"), std::string::npos);
    EXPECT_NE(message_after([](EngineState& s) { s.model.settings.time_step = -1.0; }).find("time_step = -1"), std::string::npos);
    EXPECT_NE(message_after([](EngineState& s) { s.model.settings.laws.normal = static_cast<core::NormalLaw>(7); }).find("laws.normal = 7"), std::string::npos);
    EXPECT_NE(message_after([](EngineState& s) { s.model.walls[0].plane.material = 3; }).find("wall 0 has material 3 of 3"), std::string::npos);
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
