#include "core/contact_probe.hpp"

#include "core/contact_lanes.hpp"
#include "core/law/choose.hpp"

namespace talus::core {

namespace {

template <class Law>
ContactView look(const ForceContext& context, const ContactGeometry<double>& g, const ContactParameters<double>& p, const ContactList& list, std::uint32_t contact) {
    double row[kMaxHistoryDoubles];
    list.get_history(contact, row);
    ContactState<double> x{};
    x.geometry = g;
    ContactHistory<double>& history = x.history;
    if constexpr (Law::kHistoryDoubles > 0) history.tangential = {{row[0], row[1], row[2]}, row[3]};
    if constexpr (Law::kHistoryDoubles > 4) history.rolling = {row[4], row[5], row[6]};
    ContactView v;
    v.sliding = history.tangential.last < 0.0;
    v.normal = g.normal;
    v.overlap = g.overlap;
    const auto stored = Law::stored_energy(g, p, history);
    v.elastic_normal = stored.normal;
    v.elastic_tangential = stored.tangential;
    v.elastic_rolling = stored.rolling;
    const double floor = context.laws.damping == Damping::clipped ? 0.0 : -HUGE_VAL;
    const StepConstants<double> constants{0.0, floor, context.laws.rolling_rate};
    Law::evaluate(x, p, constants);
    v.force = x.force.force;
    return v;
}

struct MakeProbes {
    template <class Law>
    static ContactView pair(const ForceContext& c, const TileIds& tile, const ContactList& list, std::uint32_t contact) {
        const LocalIndex i = tile.index_of[list.contacts[contact].i], j = tile.index_of[list.contacts[contact].j];
        const Particle *pi = &tile.particles[i], *pj = &tile.particles[j];
        const auto gi = load_grain(*pi), gj = load_grain(*pj);
        const auto g = pair_geometry<(Law::kHistoryDoubles > 4)>(c.periods, gi, gj, c.laws.rolling_radius == RollingRadius::own);
        const auto p = splat_parameters<double>(c.pairs[material_of(*pi)][material_of(*pj)]);
        ContactView v = look<Law>(c, g, p, list, contact);
        v.i = pi->label;
        v.j = pj->label;
        v.particle_i = i;
        v.particle_j = j;
        v.branch = minimum_image(c.periods, gi.position - gj.position);
        v.smaller_radius = smaller(pi->radius, pj->radius);
        return v;
    }
    template <class Law>
    static ContactView wall(const ForceContext& c, const WallPlane& w, int id, const TileIds& tile, const ContactList& list, std::uint32_t contact) {
        const LocalIndex i = tile.index_of[list.contacts[contact].i];
        const Particle* pi = &tile.particles[i];
        const auto gi = load_grain(*pi);
        const auto g = wall_geometry<(Law::kHistoryDoubles > 4)>(w.point, w.normal, w.velocity, gi);
        const auto p = splat_parameters<double>(c.pairs[material_of(*pi)][w.material]);
        ContactView v = look<Law>(c, g, p, list, contact);
        v.i = pi->label;
        v.j = kWallLabel + id;
        v.particle_i = i;
        v.branch = g.normal * (pi->radius - g.overlap);
        v.smaller_radius = pi->radius;
        return v;
    }
    template <class Law>
    static ProbeSet make() {
        return {&pair<Law>, &wall<Law>};
    }
};

} // namespace

ProbeSet select_probes(const Laws& laws) { return choose_law<MakeProbes>(laws); }

} // namespace talus::core
