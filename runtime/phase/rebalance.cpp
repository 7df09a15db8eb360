// rebalance: what the work of a rank takes, and cuts of the slice grid that share it out (core/balance.hpp).
//
// A grain costs what a grain of its old tile took: the tile's measured seconds, scaled to the rank's busy time a grain and step, which is
// smoothed over lists, since a short list's time is noisy. So a rank on a slow processor has dear grains and gets fewer of them.
// Measured times decide who works; they never reach the trajectory.
#include <algorithm>
#include <bit>
#include <cmath>

#include "core/philox.hpp"
#include "runtime/phase/phases.hpp"

namespace talus::runtime {

using core::LocalIndex;

namespace {

constexpr double kMemory = 200.0;         // steps of lists that the smoothed time of a grain rests on
constexpr double kUnit = 1e-12;           // s, of the time of a grain or a rank in a step, in sums
constexpr double kLong = 1e-9;            // s, of the time of a list's life, in sums
constexpr double kDearest = 8.0;          // times the rank's mean that a grain of a tile may cost: a tile of few grains was timed badly
constexpr std::int64_t kFirstLook = 64;   // steps after which lists may be given up for balance, and at every doubling of them
constexpr double kOtherGrid = 0.2;        // share of the halos to be spared for which all grains may change rank
constexpr int kBlock = 4096;              // grains a task

/// The box of all grains, the same on every rank; a periodic axis counts whole.
core::Box global_extent(EngineState& s) {
    std::vector<double> v(6, -HUGE_VAL);
    for (LocalIndex i = 0; i < s.sub.n_owned; ++i)
        for (int a = 0; a < 3; ++a) {
            v[a] = std::max(v[a], -s.sub.particles[i].position[a]);
            v[3 + a] = std::max(v[3 + a], s.sub.particles[i].position[a]);
        }
    s.comm->max(v);
    const core::Domain& d = s.model.settings.domain;
    core::Box box;
    for (int a = 0; a < 3; ++a) {
        box.lo[a] = d.periodic[a] || !std::isfinite(v[a]) ? d.lo[a] : -v[a];
        box.hi[a] = d.periodic[a] || !std::isfinite(v[3 + a]) ? d.hi[a] : v[3 + a];
    }
    return box;
}

/// Numbers of subdomains along the axes that give the grains the least halos. @param out_gain  of the halos there are now, that are spared
std::array<int, 3> best_grid(const EngineState& s, const core::Box& extent, double& out_gain) {
    double lengths[3];
    for (int a = 0; a < 3; ++a) lengths[a] = std::max(extent.hi[a] - extent.lo[a], s.model.diameter());
    const auto& periodic = s.model.settings.domain.periodic;
    const auto grid = core::choose_rank_grid(s.comm->size(), lengths, periodic, s.model.settings.rank_grid);
    out_gain = 1.0 - core::halo_surface(grid, lengths, periodic) / std::max(core::halo_surface(s.slices.grid(), lengths, periodic), 1e-300);
    return grid;
}

/// What a grain of each old tile costs.
class GrainCosts {
public:
    /// @param grain_seconds  of this rank's mean grain in a step
    GrainCosts(const Subdomain& sub, double grain_seconds) : store_(sub.contacts), slot_of_(sub.slot_of), mean_(units(grain_seconds)) {
        double seconds = 0.0, grains = 0.0;
        for (const core::Tile& t : store_.tiles) {
            seconds += t.seconds;
            grains += t.count;
        }
        const double scale = seconds > 0.0 ? grain_seconds * grains / seconds : 0.0;
        for (const core::Tile& t : store_.tiles) {
            const double share = t.count > 0 ? scale * t.seconds / t.count : 0.0;
            of_tile_.push_back(share > 0.0 ? units(std::min(share, kDearest * grain_seconds)) : mean_);
        }
    }
    std::int64_t operator()(LocalIndex i) const {
        const std::uint32_t slot = slot_of_[i];
        return slot < store_.n_grains ? of_tile_[static_cast<std::size_t>(&store_.tile_of(slot) - store_.tiles.data())] : mean_;
    }

private:
    static std::int64_t units(double seconds) { return std::max<std::int64_t>(1, std::llround(seconds / kUnit)); }

    const core::ContactStore& store_;
    const std::vector<std::uint32_t>& slot_of_;
    std::int64_t mean_;
    std::vector<std::int64_t> of_tile_;
};

core::SliceGrid balanced_cuts(EngineState& s, double grain_seconds) {
    const GrainCosts cost(s.sub, grain_seconds);
    const core::Box extent = global_extent(s);
    core::SliceGrid start = s.slices;
    double gain = 0.0;
    const auto grid = best_grid(s, extent, gain);
    const core::Domain& d = s.model.settings.domain;
    bool fits = true; // as Engine::refresh_lists requires
    for (int a = 0; a < 3; ++a) fits = fits && (grid[a] == 1 || d.length(a) / grid[a] >= s.model.reach());
    // Sand that has settled, or was pushed together, has another shape than what was poured.
    if (fits && gain > kOtherGrid) start = core::SliceGrid(d, grid);
    const int n_blocks = static_cast<int>((s.sub.n_owned + kBlock - 1) / kBlock);
    return core::balance(start, extent, {s.model.reach()}, [&](core::CostProfile& profile) {
        std::vector<core::CostProfile> parts(static_cast<std::size_t>(s.workers.threads()), profile); // one a worker
        s.workers.for_each(Phase::rebalance, n_blocks, [&](int b) {
            core::CostProfile& part = parts[static_cast<std::size_t>(Workers::current())];
            const LocalIndex end = std::min<LocalIndex>(s.sub.n_owned, static_cast<LocalIndex>(b + 1) * kBlock);
            for (LocalIndex i = static_cast<LocalIndex>(b) * kBlock; i < end; ++i) part.add(s.sub.particles[i].position, cost(i));
        });
        for (core::CostProfile& part : parts)
            for (std::size_t k = 0; k < profile.cost().size(); ++k) profile.cost()[k] += part.cost()[k];
        s.comm->sum(profile.cost());
    });
}

/// Cuts anywhere, for tests: the bits must not notice.
core::SliceGrid random_cuts(EngineState& s) {
    const core::Box extent = global_extent(s);
    core::SliceGrid cut = s.slices;
    std::uint64_t item = static_cast<std::uint64_t>(s.counters.rebuilds) << 32;
    for (int a = 0; a < 3; ++a) {
        auto& cuts = cut.cuts(a);
        for (double& c : cuts) c = extent.lo[a] + (extent.hi[a] - extent.lo[a]) * core::random_unit(s.model.settings.seed, core::RandomStream::random_cuts, item++)[0];
        const auto n = static_cast<std::ptrdiff_t>(cut.grid()[a]) - 1;
        for (auto g = cuts.begin(); g != cuts.end(); g += n) std::sort(g, g + n);
    }
    return cut;
}

/// Learn from the lists that were what a grain takes, on this rank and in the mean, and tell the ledger.
void learn_costs(EngineState& s) {
    LoadWatch& load = s.load;
    const double busy = load.busy_since(s.workers), steps = static_cast<double>(s.model.step - s.watch.built_step), grains = s.sub.n_owned;
    if (steps > 0.0 && grains > 0.0 && busy > 0.0) {
        const double now = busy / (steps * grains);
        load.grain_seconds = load.grain_seconds > 0.0 ? load.grain_seconds + steps / (steps + kMemory) * (now - load.grain_seconds) : now;
    }
    const bool known = load.grain_seconds > 0.0;
    const double own = load.grain_seconds * grains;
    std::vector<std::int64_t> sum{std::llround(own / kUnit), std::llround(busy / kLong), known ? static_cast<std::int64_t>(s.sub.n_owned) : 0};
    s.comm->sum(sum);
    std::vector<double> most{own, busy, load.move_seconds};
    s.comm->max(most);
    const auto mean_of = [&](std::int64_t v, double unit) { return unit * static_cast<double>(v) / s.comm->size(); };
    load.mean = mean_of(sum[0], kUnit);
    load.move_seconds = 0.0;
    if (most[2] > 0.0) load.ledger.add_price(most[2]);
    if (!known && sum[2] > 0) load.grain_seconds = kUnit * static_cast<double>(sum[0]) / static_cast<double>(sum[2]); // empty so far: like the others
    if (steps > 0.0) {
        load.ledger.add(most[0], load.mean, steps);
        s.counters.imbalance = sum[1] > 0 ? most[1] / mean_of(sum[1], kLong) : 1.0;
    }
}

bool is_due(EngineState& s) {
    LoadWatch& load = s.load;
    switch (s.model.settings.rebalance) {
    case Rebalance::automatic: return load.ledger.pays();
    case Rebalance::every:
    case Rebalance::random:
        if (++load.rebuilds < s.model.settings.rebalance_interval) return false;
        load.rebuilds = 0;
        return true;
    case Rebalance::off: break;
    }
    return false;
}

/// @return whether any cut moved
bool move_cuts(EngineState& s, bool first) {
    const bool random = s.model.settings.rebalance == Rebalance::random && !first;
    core::SliceGrid cuts = random ? random_cuts(s) : balanced_cuts(s, s.load.grain_seconds > 0.0 ? s.load.grain_seconds : kUnit);
    if (cuts == s.slices) return false;
    s.slices = std::move(cuts);
    s.load.ledger.moved();
    return true;
}

} // namespace

void choose_slices(EngineState& s) {
    double gain = 0.0;
    s.slices = core::SliceGrid(s.model.settings.domain, {1, 1, 1});
    s.slices = core::SliceGrid(s.model.settings.domain, best_grid(s, global_extent(s), gain));
}

void begin_load(EngineState& s, double rebuild_seconds) {
    s.load.busy_before = LoadWatch::step_seconds(s.workers);
    s.load.rebuild_seconds = rebuild_seconds;
}

void rebalance(EngineState& s, bool first) {
    if (!s.parallel()) return;
    learn_costs(s);
    const auto from = Workers::Clock::now();
    const bool moved = (first || is_due(s)) && move_cuts(s, first);
    migrate(s);
    if (!moved || first) return; // at first grains come from anywhere: that is no price of a later move
    ++s.counters.rebalances;
    s.load.move_seconds = std::chrono::duration<double>(Workers::Clock::now() - from).count();
}

LoadOpinion load_opinion(const EngineState& s, std::int64_t steps) {
    if (s.model.settings.rebalance != Rebalance::automatic || steps < kFirstLook || !std::has_single_bit(static_cast<std::uint64_t>(steps))) return {};
    return {s.load.busy_since(s.workers), s.load.rebuild_seconds};
}

bool outlived_balance(const EngineState& s, std::int64_t steps, double busiest, double idlest, double rebuild_seconds) {
    const LoadWatch& load = s.load;
    // Half of the difference is what two ranks would lose; it tells imbalance from a machine that has become slower as a whole.
    double lost = 0.5 * (busiest - idlest);
    if (load.mean > 0.0) lost = std::min(lost, core::BalanceLedger::waste(busiest / static_cast<double>(steps), load.mean, static_cast<double>(steps)));
    return lost > rebuild_seconds + load.ledger.price();
}

} // namespace talus::runtime
