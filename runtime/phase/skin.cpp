// skin: what the lists cost and how far they are used up, and from both the skin of the next ones (core/skin_choice.hpp).
//
// Counts and times are summed over ranks; the use of the skin is agreed in every step. So all ranks choose the same skin, and only at
// rebuilds. It depends on measured times; the trajectory does not depend on it.
#include <bit>
#include <cmath>

#include "runtime/phase/phases.hpp"

namespace talus::runtime {

namespace {

constexpr std::int64_t kFirstLook = 64;     // steps after which a list may be outlived, and at every doubling of them
constexpr std::int64_t kUnknownLists = 256; // steps that the first list serves at most, since its costs teach what lists cost
constexpr double kRoom = 1.0 - 1e-12;       // for the rounding of sums of lengths

/// The widest skin that the domain and its subdomains have room for: see Engine::refresh_lists.
double most_skin(const EngineState& s) {
    const core::Domain& d = s.model.settings.domain;
    double reach = HUGE_VAL;
    for (int a = 0; a < 3; ++a) {
        if (d.periodic[a]) reach = std::min(reach, 0.5 * d.length(a));
        if (s.slices.grid()[a] > 1) reach = std::min(reach, d.length(a) / s.slices.grid()[a]);
    }
    return kRoom * reach - s.model.diameter();
}

/// What is known, told of the lists in use: their skin, and how fast it is used up.
core::SkinModel present(const EngineState& s) {
    core::SkinModel m = s.watch.known;
    m.candidates = m.candidates_at(s.model.skin());
    m.skin = s.model.skin();
    m.diameter = s.model.diameter();
    const double steps = static_cast<double>(s.watch.steps) + core::kForeseenSteps;
    m.near_rate = s.watch.skin_use * m.skin / steps;
    m.far_rate = s.watch.apart / steps;
    return m;
}

} // namespace

void begin_watch(EngineState& s, double rebuild_seconds) {
    ListWatch& w = s.watch;
    w.built_step = s.model.step;
    w.rebuild_seconds = rebuild_seconds;
    w.force_before = s.workers.total(Phase::force).seconds;
    w.steps = -1;
    w.skin_use = w.apart = 0.0;
    w.counted = false;
}

void end_watch(EngineState& s) {
    ListWatch& w = s.watch;
    w.force_seconds = s.workers.total(Phase::force).seconds - w.force_before;
    w.contacts = w.candidates = 0;
    for (const core::Tile& tile : s.sub.tiles) {
        w.contacts += tile.pairs.n_contacts;
        w.candidates += tile.pairs.n_contacts + tile.pairs.n_candidates;
    }
    w.counted = true;
}

void choose_skin(EngineState& s) {
    ListWatch& w = s.watch;
    const auto nanoseconds = [](double seconds) { return static_cast<std::int64_t>(seconds * 1e9); };
    std::vector<std::int64_t> sum{nanoseconds(w.force_seconds), nanoseconds(w.rebuild_seconds), w.contacts, w.candidates, static_cast<std::int64_t>(s.sub.n_owned)};
    s.comm->sum(sum);
    Model& model = s.model;
    const double d = model.diameter(), most = most_skin(s);
    const std::int64_t served = model.step - w.built_step;
    if (model.automatic_skin() && w.counted && w.steps >= 0 && served > 0 && sum[3] > 0 && std::isfinite(w.skin_use + w.apart)) {
        // First what the lists were, then what is expected of the next.
        w.known.diameter = d;
        w.known.skin = model.skin();
        w.known.contacts = static_cast<double>(sum[2]);
        w.known.candidates = static_cast<double>(sum[3]);
        w.known.grains = static_cast<double>(sum[4]);
        w.known.learn(1e-9 * static_cast<double>(sum[0]) / static_cast<double>(served), 1e-9 * static_cast<double>(sum[1]));
        model.skin_share = core::next_skin(present(s), most) / d;
    }
    w.counted = false;
    if (w.disturbed) model.skin_share = std::max(model.skin_share, core::kFirstSkin);
    w.disturbed = false;
    // Also when nothing was learnt: larger grains may have come.
    model.skin_share = std::min(model.skin_share, std::max(core::kFirstSkin, most / d));
}

bool watch_lists(EngineState& s, std::int64_t steps, double skin_use, double apart) {
    ListWatch& w = s.watch;
    w.steps = steps;
    w.skin_use = skin_use;
    w.apart = apart;
    if (!s.model.automatic_skin() || steps < kFirstLook || !std::has_single_bit(static_cast<std::uint64_t>(steps))) return false;
    if (w.known.candidates == 0.0) return steps >= kUnknownLists;
    return std::isfinite(skin_use + apart) && core::outlived(present(s), most_skin(s), static_cast<double>(steps));
}

} // namespace talus::runtime
