// kernel_bench.hpp: a tile with random grains, candidate pairs and walls, on which a force kernel can be run. For tests from inside.
#pragma once

#include <map>
#include <vector>

#include "bed.hpp"
#include "core/force_kernel.hpp"
#include "core/tile.hpp"

namespace talus::test {

/// All combinations of laws that are allowed.
inline std::vector<core::Laws> all_laws() {
    using namespace core;
    std::vector<Laws> all;
    for (const NormalLaw normal : {NormalLaw::hertz, NormalLaw::linear})
        for (const Damping damping : {Damping::clipped, Damping::attractive})
            for (int tangential = 0; tangential < 4; ++tangential)
                for (int rolling = 0; rolling < 3; ++rolling)
                    for (const RollingRadius radius : {RollingRadius::effective, RollingRadius::own})
                        for (const bool tangential_damping : {true, false}) {
                            Laws l;
                            l.normal = normal;
                            l.damping = damping;
                            l.tangential = static_cast<TangentialLaw>(tangential);
                            l.rolling = static_cast<RollingLaw>(rolling);
                            l.rolling_radius = radius;
                            l.tangential_damping = tangential_damping;
                            l.stiffness_n = 3.0e3;
                            if (laws_fault(l) == nullptr) all.push_back(l);
                        }
    return all;
}

inline std::string name_of(const core::Laws& l) {
    return "normal " + std::to_string(static_cast<int>(l.normal)) + ", damping " + std::to_string(static_cast<int>(l.damping)) + ", tangential " + std::to_string(static_cast<int>(l.tangential)) +
           (l.tangential_damping ? " damped" : "") + ", rolling " + std::to_string(static_cast<int>(l.rolling)) + ", rolling radius " + std::to_string(static_cast<int>(l.rolling_radius));
}

struct KernelBench {
    static constexpr double kRadius = 1.0e-3;
    core::ForceContext context;
    std::vector<core::Particle> particles;
    core::Tile tile;
    core::TileGrains grains;
    std::vector<core::WallPlane> walls;
    core::HeatSum heat;
    core::CapBreach breach;

    /// @param n_pairs any number: batches have tails. The cap is far above all forces here.
    KernelBench(const core::Laws& laws, int n_grains, int n_pairs, int n_materials, std::uint64_t seed) {
        Random random(seed);
        core::Domain domain;
        for (int a = 0; a < 3; ++a) domain.hi[a] = 20.0 * kRadius;
        domain.periodic[0] = true;
        context.laws = laws;
        context.periods = core::Periods(domain);
        context.dt = 1.0e-6;
        context.n_materials = n_materials;
        double young = 0.0;
        std::vector<core::Material> materials;
        for (int m = 0; m <= n_materials; ++m) materials.push_back({1.0e7 * (m + 1), 0.1 + 0.1 * m, 2000.0 + 500.0 * m, false}); // the last is the walls'
        for (int a = 0; a <= n_materials; ++a)
            for (int b = 0; b <= n_materials; ++b) {
                const core::ContactMaterial c{0.2 + 0.2 * ((a + b) % 4), 0.25 * ((a * b) % 4), 0.1 * (a + b), true};
                context.pairs[a][b] = core::derive_parameters(materials[a], materials[b], c, laws);
                young = std::max(young, core::effective_young(materials[a], materials[b]));
            }
        context.units = core::FixedUnits::make(30.0 * std::max(4.0 / 3.0 * young * 4 * kRadius * kRadius, 10.0 * laws.stiffness_n * kRadius), 2.0 * kRadius, 20.0 * kRadius);

        for (int k = 0; k < n_grains; ++k) {
            core::Particle p{};
            const int material = k % n_materials;
            p.radius = kRadius * random.uniform(0.5, 1.5);
            for (int a = 0; a < 3; ++a) {
                // A third of the grains stands on each side of the periodic seam.
                p.position[a] = a == 0 && k % 3 == 0 ? random.uniform(0.0, kRadius) : a == 0 && k % 3 == 1 ? 20.0 * kRadius - random.uniform(0.0, kRadius) : random.uniform(0.0, 4.0 * kRadius);
                p.velocity[a] = random.uniform(-0.5, 0.5);
                p.angular_velocity[a] = random.uniform(-300.0, 300.0);
            }
            p.mass = materials[material].density * 4.0 / 3.0 * core::kPi * p.radius * p.radius * p.radius;
            p.meta = core::make_meta(material, k % 5, k % 256);
            p.label = (k * 7919LL) % 10007;
            particles.push_back(p);
            tile.index_of.push_back(static_cast<core::LocalIndex>(k));
        }
        tile.count = static_cast<std::uint32_t>(n_grains);
        tile.sums.assign(particles.size(), core::ForceSum{});
        tile.pairs.start(core::history_doubles(laws));
        for (int k = 0; k < n_pairs; ++k) {
            const int i = static_cast<int>(random.uniform(0, n_grains)), j = (i + 1 + static_cast<int>(random.uniform(0, n_grains - 1))) % n_grains;
            list(i, j);
        }
        walls = {{{0, 0.4 * kRadius, 0}, {0, 1, 0}, {0.1, 0, 0.05}, n_materials}, {{0, 3.0 * kRadius, 0}, {0.6, -0.8, 0}, {0, 0.1, 0}, n_materials}};
        tile.walls.resize(walls.size());
        tile.wall_sums.resize(walls.size());
        for (auto& w : tile.walls) {
            w.start(core::history_doubles(laws));
            for (int k = 0; k < n_grains; ++k) w.add_candidate({static_cast<core::TileLocal>(k), static_cast<core::TileLocal>(k)});
        }
    }
    void list(int a, int b) {
        if (particles[b].label < particles[a].label) std::swap(a, b);
        tile.pairs.add_candidate({static_cast<core::TileLocal>(a), static_cast<core::TileLocal>(b)});
    }
    void clear_sums() {
        std::fill(tile.sums.begin(), tile.sums.end(), core::ForceSum{});
        std::fill(tile.wall_sums.begin(), tile.wall_sums.end(), core::WallSum{});
    }
    void evaluate(core::KernelWidth width, bool with_walls = true) {
        const core::KernelSet kernels = core::select_kernels(context.laws, context.ledger, width);
        grains.gather(particles.data(), tile.index_of);
        const core::TileForces work{{particles.data(), static_cast<core::LocalIndex>(particles.size()), tile.index_of.data()}, &grains, tile.sums.data()};
        kernels.pair(context, work, tile.pairs, heat, breach);
        for (std::size_t w = 0; with_walls && w < walls.size(); ++w) kernels.wall(context, walls[w], static_cast<int>(w), work, tile.walls[w], tile.wall_sums[w], heat, breach);
    }
    /// Move the grains a little, so that contacts come, go, slide and turn.
    void drift(double dt) {
        for (core::Particle& p : particles)
            for (int a = 0; a < 3; ++a) p.position[a] += dt * p.velocity[a];
    }
};

using OpenContacts = std::map<std::pair<core::TileLocal, core::TileLocal>, std::vector<std::uint64_t>>;

/// The contacts of a list that touch, and the bits of their histories.
inline OpenContacts open_contacts(const core::ContactList& list) {
    OpenContacts open;
    for (std::uint32_t k = 0; k < list.n_contacts; ++k) {
        if (!list.touches(k)) continue;
        double row[core::kMaxHistoryDoubles];
        list.get_history(k, row);
        auto& bits = open[{list.contacts[k].i, list.contacts[k].j}];
        bits.clear();
        for (int c = 0; c < list.history_doubles; ++c) bits.push_back(__builtin_bit_cast(std::uint64_t, row[c]));
    }
    return open;
}

inline std::vector<std::int64_t> numbers(const std::vector<core::ForceSum>& sums) {
    std::vector<std::int64_t> v;
    for (const core::ForceSum& s : sums) {
        v.insert(v.end(), s.force, s.force + 3);
        v.insert(v.end(), s.torque, s.torque + 3);
    }
    return v;
}

} // namespace talus::test
