#include "runtime/kept_state.hpp"

#include <algorithm>

#include "runtime/phase/phases.hpp"

namespace talus::runtime {

KeptState::KeptState(EngineState& s) : model_(s.model) {
    const Subdomain& sub = s.sub;
    TALUS_CHECK(!sub.laid_out);
    std::copy_n(&s.force.pairs[0][0], core::kMaxMaterials * core::kMaxMaterials, &pairs_[0][0]);
    particles_.assign(sub.particles.begin(), sub.particles.begin() + sub.n_owned);
    references_ = sub.references;
    sums_.resize(sub.n_owned);
    heat_ = sub.heat;
    for (const core::Tile& tile : sub.tiles) {
        std::copy_n(tile.sums.begin(), tile.count, sums_.begin() + tile.first);
        heat_.friction += tile.heat.friction;
        heat_.damping += tile.heat.damping;
        heat_.rolling += tile.heat.rolling;
    }
    wall_last_ = sub.wall_last;
    wall_impulse_ = sub.wall_impulse;

    core::ContactStore now;
    lay_out_contacts(s, now);
    contacts_.history_doubles = now.history_doubles;
    std::vector<core::Label> partners;
    std::vector<double> rows;
    for (core::LocalIndex i = 0; i < sub.n_owned; ++i) {
        partners.clear();
        rows.clear();
        now.each(i, [&](core::Label partner, const core::HistoryPlace& place) {
            double row[core::kMaxHistoryDoubles];
            now.get(place, row);
            partners.push_back(partner);
            rows.insert(rows.end(), row, row + now.history_doubles);
        });
        contacts_.append(partners.data(), rows.data(), static_cast<std::uint32_t>(partners.size()));
    }
    for (core::Tile& t : s.sub.tiles) t.by_grain = core::ContactsByGrain{};
}

void KeptState::restore(EngineState& s) const {
    s.model = model_;
    for (Wall& w : s.model.walls) w.listed_point = w.plane.point;
    std::copy_n(&pairs_[0][0], core::kMaxMaterials * core::kMaxMaterials, &s.force.pairs[0][0]);
    Subdomain& sub = s.sub;
    sub.hold(particles_, references_, sums_, contacts_);
    sub.heat = heat_;
    sub.wall_last = wall_last_;
    sub.wall_impulse = wall_impulse_;
}

} // namespace talus::runtime
