#include "runtime/io/checkpoint_check.hpp"

#include <algorithm>
#include <cmath>

namespace talus::runtime {

using core::Label;

namespace {

class Faults {
public:
    template <class... Args>
    void add(fmt::format_string<Args...> format, Args&&... args) {
        if (!text_.empty()) text_ += '\n';
        text_ += fmt::format(format, std::forward<Args>(args)...);
    }
    void require(bool good, const char* what) {
        if (!good) add("{}", what);
    }
    std::string take() { return std::move(text_); }

private:
    std::string text_;
};

template <class... T>
bool all_finite(T... x) {
    return (std::isfinite(x) && ...);
}
bool all_finite(const core::Vec3d& v) { return all_finite(v.x, v.y, v.z); }
bool all_finite(const double (&v)[3]) { return all_finite(v[0], v[1], v[2]); }

bool power_of_two(const core::FixedUnit& u) {
    int exponent;
    return u.unit > 0.0 && all_finite(u.unit, u.scale) && std::frexp(u.unit, &exponent) == 0.5 && u.unit * u.scale == 1.0;
}

void check_materials(const Model& m, const PairTable& pairs, Faults& f) {
    const std::size_t n = m.materials.size();
    for (std::size_t a = 0; a < n; ++a) {
        const core::Material& x = m.materials[a];
        if (!x.rigid && !(x.young > 0.0 && all_finite(x.young) && x.poisson >= 0.0 && x.poisson < 0.5 && x.density >= 0.0 && all_finite(x.density)))
            f.add("material {} has young {}, poisson {}, density {}", a, x.young, x.poisson, x.density);
        for (std::size_t b = 0; b < n; ++b) {
            const core::ContactMaterial& c = m.contacts[a][b];
            if (c.is_set && !(c.restitution > 0.0 && c.restitution <= 1.0 && c.friction >= 0.0 && c.rolling_friction >= 0.0 && all_finite(c.friction, c.rolling_friction)))
                f.add("contact of materials {} and {} has restitution {}, friction {}, rolling friction {}", a, b, c.restitution, c.friction, c.rolling_friction);
            const core::PairParameters& p = pairs[a][b];
            if (!all_finite(p.stiffness_n, p.stiffness_t, p.damping_n, p.damping_t, p.friction, p.rolling_friction, p.rolling_damping)) f.add("derived constants of materials {} and {} are not finite", a, b);
        }
    }
}

std::uint64_t spread(Label label) {
    // Any mixing will do: it only shares labels out over ranks.
    std::uint64_t x = static_cast<std::uint64_t>(label) * 0x9e3779b97f4a7c15u;
    return x ^ x >> 32;
}

} // namespace

std::string model_faults(const Model& m, const PairTable& pairs) {
    Faults f;
    Settings physics = m.settings; // what stayed as the caller has it is not the file's fault
    const Settings standard;
    physics.threads = standard.threads;
    physics.skin = standard.skin;
    physics.tile_grains = standard.tile_grains;
    physics.rebalance = standard.rebalance;
    physics.rank_grid = standard.rank_grid;
    if (const std::string faults = settings_faults(physics, 1); !faults.empty()) f.add("{}", faults);
    check_materials(m, pairs, f);
    for (std::size_t w = 0; w < m.walls.size(); ++w) {
        const core::WallPlane& p = m.walls[w].plane;
        if (p.material < 0 || p.material >= static_cast<int>(m.materials.size())) f.add("wall {} has material {} of {}", w, p.material, m.materials.size());
        if (!all_finite(p.point) || !all_finite(p.velocity) || !all_finite(m.walls[w].work) || !(std::fabs(core::dot(p.normal, p.normal) - 1.0) < 1e-9)) f.add("wall {} has a position, normal, velocity or work that cannot be", w);
    }
    for (const core::GroupMotion& g : m.groups) {
        f.require(static_cast<int>(g.mode) >= 0 && static_cast<int>(g.mode) <= 2, "a group has an unknown mode");
        f.require(all_finite(g.velocity) && all_finite(g.angular_velocity), "a group has a velocity that is not finite");
    }
    f.require(m.step >= 0 && all_finite(m.time), "the clock cannot be");
    f.require(m.n_particles >= 0, "the number of grains is negative");
    f.require(all_finite(m.radius_min, m.radius_max) && m.radius_min >= 0.0 && m.radius_max >= m.radius_min, "the extreme radii cannot be");
    if (m.units_fixed) f.require(power_of_two(m.units.force) && power_of_two(m.units.torque) && power_of_two(m.units.wall_torque), "the units of the sums are not powers of two");
    return f.take();
}

std::string grain_fault(const Model& m, const std::vector<core::Particle>& grains, const std::vector<core::Reference>& references) {
    for (std::size_t i = 0; i < grains.size(); ++i) {
        const core::Particle& p = grains[i];
        if (p.label < 0 || p.label >= core::kWallLabel) return fmt::format("a grain has the label {}", p.label);
        if (!all_finite(p.position) || !all_finite(p.velocity) || !all_finite(p.angular_velocity) || !all_finite(references[i][0], references[i][1], references[i][2])) return fmt::format("grain {} has a number that is not finite", p.label);
        if (!(p.radius >= m.radius_min && p.radius <= m.radius_max && p.radius > 0.0)) return fmt::format("grain {} has the radius {} m; radii are {} to {} m", p.label, p.radius, m.radius_min, m.radius_max);
        if (!(p.mass > 0.0) || !all_finite(p.mass)) return fmt::format("grain {} has the mass {} kg", p.label, p.mass);
        if (core::material_of(p) >= static_cast<int>(m.materials.size()) || core::group_of(p) >= core::kMaxGroups) return fmt::format("grain {} has material {} and group {}, which do not exist", p.label, core::material_of(p), core::group_of(p));
    }
    return {};
}

std::string contact_fault(const Model& m, const std::vector<core::Particle>& grains, const core::ContactStore& contacts) {
    const auto walls = static_cast<Label>(m.walls.size());
    for (std::size_t i = 0; i < grains.size(); ++i)
        for (std::uint32_t e = contacts.first[i]; e < contacts.first[i + 1]; ++e) {
            const Label partner = contacts.partners[e];
            if (partner < 0 || partner == grains[i].label || partner >= core::kWallLabel + walls) return fmt::format("grain {} touches {}, which does not exist", grains[i].label, partner);
            if (e > contacts.first[i] && contacts.partners[e - 1] >= partner) return fmt::format("the contacts of grain {} are not in the order of their partners", grains[i].label);
            const double* row = contacts.rows.data() + std::size_t{e} * static_cast<std::size_t>(contacts.history_doubles);
            if (!std::all_of(row, row + contacts.history_doubles, [](double v) { return std::isfinite(v); })) return fmt::format("the contact of grain {} and {} has a history that is not finite", grains[i].label, partner);
        }
    return {};
}

std::string pairing_fault(Communicator& comm, const std::vector<core::Particle>& grains, const core::ContactStore& contacts) {
    // Seen from the smaller label and from the larger one the pairs must give the same sum, whoever holds them.
    core::Digest balance;
    for (std::size_t i = 0; i < grains.size(); ++i)
        for (std::uint32_t e = contacts.first[i]; e < contacts.first[i + 1]; ++e) {
            const Label mine = grains[i].label, partner = contacts.partners[e];
            if (partner >= core::kWallLabel) continue;
            core::Digest one;
            one.add_contact(std::min(mine, partner), std::max(mine, partner), contacts.rows.data() + std::size_t{e} * static_cast<std::size_t>(contacts.history_doubles), contacts.history_doubles);
            balance.lo += mine < partner ? one.lo : -one.lo;
            balance.hi += mine < partner ? one.hi : -one.hi;
        }
    const std::uint64_t lo = comm.sum_modulo(balance.lo), hi = comm.sum_modulo(balance.hi);

    // Equal labels meet on one rank.
    std::vector<Parcel> parcels;
    for (int r = 0; r < comm.size(); ++r) parcels.push_back({r, {}});
    for (const core::Particle& p : grains) {
        Bytes& to = parcels[spread(p.label) % static_cast<std::uint64_t>(comm.size())].data;
        const auto* bytes = reinterpret_cast<const std::byte*>(&p.label);
        to.insert(to.end(), bytes, bytes + sizeof p.label);
    }
    std::erase_if(parcels, [](const Parcel& p) { return p.data.empty(); });
    std::vector<Label> labels;
    for (const Parcel& p : comm.sparse_exchange(std::move(parcels))) {
        const std::size_t n = labels.size();
        labels.resize(n + p.data.size() / sizeof(Label));
        std::memcpy(labels.data() + n, p.data.data(), p.data.size());
    }
    std::sort(labels.begin(), labels.end());
    const auto twice = std::adjacent_find(labels.begin(), labels.end());
    // The smallest, so that the message is the same on any ranks.
    if (const Label least = -comm.max(twice == labels.end() ? -core::kWallLabel : -*twice); least < core::kWallLabel) return fmt::format("two grains have the label {}", least);
    if (lo != 0 || hi != 0) return "the contacts of some pair differ between its two grains";
    return {};
}

} // namespace talus::runtime
