// tests/support/checkpoint_case.hpp: a state with every kind of content, and the fixture that saves, loads and compares it.
#pragma once

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
        std::map<std::pair<Label, Label>, std::array<double, core::kMaxHistoryDoubles>> rows;
        const auto row_of = [&](Label a, Label b) -> const double* {
            const auto [at, fresh] = rows.try_emplace({std::min(a, b), std::max(a, b)});
            if (fresh)
                for (double& v : at->second) v = any();
            return at->second.data();
        };
        Subdomain& sub = s.sub;
        const int doubles = core::history_doubles(s.model.settings.laws);
        sub.contacts.history_doubles = doubles;
        sub.keeps_sums = true;
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
                    std::vector<double> of_grain;
                    for (const Label other : partners) of_grain.insert(of_grain.end(), row_of(p.label, other), row_of(p.label, other) + doubles);
                    sub.particles.push_back(p);
                    sub.references.push_back(reference);
                    sub.sums.push_back(sum);
                    sub.slot_of.push_back(sub.contacts.append(partners.data(), of_grain.data(), static_cast<std::uint32_t>(partners.size())));
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
    if (!s.sub.laid_out) empty_tiles(s, true);
    const Subdomain& sub = s.sub;
    for (core::LocalIndex i = 0; i < sub.n_owned; ++i) {
        const Particle& p = sub.particles[i];
        c.grains[p.label] = bytes_of({{p.position, 96}, {sub.references[i].data(), 24}, {sub.sums[i].force, 24}, {sub.sums[i].torque, 24}});
        sub.contacts.open(sub.slot_of[i]);
        sub.contacts.each(sub.slot_of[i], [&](Label partner, const core::HistoryPlace& place) {
            double row[core::kMaxHistoryDoubles];
            sub.contacts.get(place, row);
            c.contacts[{p.label, partner}] = bytes_of({{row, sizeof(double) * static_cast<std::size_t>(sub.contacts.history_doubles)}});
        });
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

inline void expect_equal(EngineState& a, EngineState& b) {
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

} // namespace
} // namespace talus::runtime
