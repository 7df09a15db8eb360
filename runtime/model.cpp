#include "runtime/model.hpp"

#include <xxhash.h>

#include "runtime/comm/packing_buffer.hpp"

namespace talus::runtime {

std::array<std::uint64_t, kModelParts.size()> fingerprints(const Model& m) {
    const Settings& s = m.settings;
    // Field by field: the bytes between fields are nobody's.
    std::array<Packer, kModelParts.size()> part;
    const auto put = [](Packer& p, const auto&... fields) { (p.put(fields), ...); };
    put(part[0], s.domain.lo, s.domain.hi, s.domain.periodic, s.gravity, s.time_step, s.time_step_limit, s.skin, s.radius_max, s.rebalance, s.rebalance_interval, s.rank_grid, s.energy_ledger, s.seed);
    const core::Laws& l = s.laws;
    put(part[1], l.normal, l.damping, l.tangential, l.rolling, l.rolling_radius, l.tangential_damping, l.rolling_rate, l.rolling_damping, l.stiffness_n, l.stiffness_t);
    for (const core::Material& a : m.materials) put(part[2], a.young, a.poisson, a.density, a.rigid);
    for (const auto& row : m.contacts)
        for (const core::ContactMaterial& c : row) put(part[3], c.restitution, c.friction, c.rolling_friction, c.is_set);
    for (const Wall& w : m.walls) put(part[4], w.plane.point, w.plane.normal, w.plane.velocity, w.plane.material);
    for (const core::GroupMotion& g : m.groups) put(part[5], g.mode, g.velocity, g.angular_velocity);
    std::array<std::uint64_t, kModelParts.size()> out{};
    for (std::size_t k = 0; k < part.size(); ++k) {
        const Bytes bytes = part[k].take();
        out[k] = XXH3_64bits(bytes.data(), bytes.size());
    }
    return out;
}

} // namespace talus::runtime
