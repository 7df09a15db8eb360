// rebalance: cuts of the slice grid from cost histograms, and the migration of grains to their owners.
#include <algorithm>
#include <cmath>

#include "core/philox.hpp"
#include "runtime/comm/packing_buffer.hpp"
#include "runtime/phase/phases.hpp"

namespace talus::runtime {

using core::LocalIndex;
using core::Particle;

namespace {

constexpr int kBins = 1024;               // of a cost histogram
constexpr double kTolerance = 1.1;        // automatic: imbalance that is not worth a move
constexpr std::int64_t kCostUnits = 1024; // cost of a grain of mean cost

/// The box of all grains, the same on every rank.
void global_extent(EngineState& s, double (&lo)[3], double (&hi)[3]) {
    std::vector<double> v(6, -HUGE_VAL);
    for (LocalIndex i = 0; i < s.sub.n_owned; ++i)
        for (int a = 0; a < 3; ++a) {
            v[a] = std::max(v[a], -s.sub.particles[i].position[a]);
            v[3 + a] = std::max(v[3 + a], s.sub.particles[i].position[a]);
        }
    s.comm->max(v);
    const core::Domain& d = s.model.settings.domain;
    for (int a = 0; a < 3; ++a) {
        lo[a] = d.periodic[a] || !std::isfinite(v[a]) ? d.lo[a] : -v[a];
        hi[a] = d.periodic[a] || !std::isfinite(v[3 + a]) ? d.hi[a] : v[3 + a];
    }
}

/// New cuts along x, then z within the slabs, then y; each from one summed histogram.
void balanced_cuts(EngineState& s, std::int64_t grain_cost) {
    double lo[3], hi[3];
    global_extent(s, lo, hi);
    const auto grid = s.slices.grid();
    const double reach = s.model.reach();
    core::SliceGrid cut = s.slices;
    const auto one_axis = [&](int axis, int groups, auto group_of) {
        const int parts = grid[axis];
        if (parts == 1) return;
        std::vector<std::int64_t> cost(static_cast<std::size_t>(groups) * kBins, 0);
        const double scale = kBins / std::max(hi[axis] - lo[axis], 1e-300);
        for (LocalIndex i = 0; i < s.sub.n_owned; ++i) {
            const double* x = s.sub.particles[i].position;
            const int bin = std::clamp(static_cast<int>((x[axis] - lo[axis]) * scale), 0, kBins - 1);
            cost[static_cast<std::size_t>(group_of(x)) * kBins + bin] += grain_cost;
        }
        s.comm->sum(cost);
        const double least = std::min(reach, (hi[axis] - lo[axis]) / parts);
        for (int g = 0; g < groups; ++g)
            core::cut_histogram(&cost[static_cast<std::size_t>(g) * kBins], kBins, lo[axis], hi[axis], parts, least, cut.cuts(axis).data() + static_cast<std::size_t>(g) * (parts - 1));
    };
    // The owner under the cuts found so far names the slab, and the column within it.
    one_axis(0, 1, [](const double*) { return 0; });
    one_axis(2, grid[0], [&](const double* x) { return cut.owner(x) / (grid[1] * grid[2]); });
    one_axis(1, grid[0] * grid[2], [&](const double* x) { return cut.owner(x) / grid[1]; });
    s.slices = cut;
}

/// Cuts anywhere, for tests: the bits must not notice.
void random_cuts(EngineState& s) {
    double lo[3], hi[3];
    global_extent(s, lo, hi);
    const auto grid = s.slices.grid();
    std::uint64_t item = static_cast<std::uint64_t>(s.counters.rebuilds) << 32;
    for (int a = 0; a < 3; ++a) {
        auto& cuts = s.slices.cuts(a);
        for (double& c : cuts) c = lo[a] + (hi[a] - lo[a]) * core::random_unit(s.model.settings.seed, core::RandomStream::random_cuts, item++)[0];
        for (std::size_t k = 0; k < cuts.size(); k += static_cast<std::size_t>(grid[a] - 1)) std::sort(cuts.begin() + static_cast<std::ptrdiff_t>(k), cuts.begin() + static_cast<std::ptrdiff_t>(k) + grid[a] - 1);
    }
}

/// Send grains whose owner is another rank, with references, contacts and, where they are kept, sums.
void migrate(EngineState& s) {
    Subdomain& sub = s.sub;
    core::ContactStore& contacts = sub.contacts;
    const int me = s.comm->rank();
    const auto doubles = static_cast<std::size_t>(contacts.history_doubles);
    std::vector<Packer> packers(static_cast<std::size_t>(s.comm->size()));
    std::int64_t left = 0;
    std::vector<core::Label> partners;
    std::vector<double> rows;
    sub.keep_owned([&](LocalIndex i) {
        const int owner = s.slices.owner(sub.particles[i].position);
        if (owner == me) return true;
        ++left;
        Packer& p = packers[owner];
        p.put(sub.particles[i]);
        p.put(sub.references[i]);
        if (sub.keeps_sums) p.put(sub.sums[i]);
        partners.clear();
        rows.clear();
        contacts.open(sub.slot_of[i]);
        contacts.each(sub.slot_of[i], [&](core::Label partner, const core::HistoryPlace& place) {
            partners.push_back(partner);
            rows.resize(rows.size() + doubles);
            contacts.get(place, rows.data() + rows.size() - doubles);
        });
        p.put(static_cast<std::uint32_t>(partners.size()));
        p.put_many(partners.data(), partners.size());
        p.put_many(rows.data(), rows.size());
        return false;
    });
    std::vector<Parcel> parcels;
    for (int r = 0; r < s.comm->size(); ++r)
        if (!packers[r].empty()) parcels.push_back({r, packers[r].take()});

    for (const Parcel& parcel : s.comm->sparse_exchange(std::move(parcels))) {
        Unpacker u(parcel.data);
        while (!u.done()) {
            sub.particles.push_back(u.get<Particle>());
            sub.references.push_back(u.get<core::Reference>());
            if (sub.keeps_sums) sub.sums.push_back(u.get<core::ForceSum>());
            const auto n = u.get<std::uint32_t>();
            partners.resize(n);
            rows.resize(n * doubles);
            u.get_many(partners.data(), partners.size());
            u.get_many(rows.data(), rows.size());
            sub.slot_of.push_back(contacts.append(partners.data(), rows.data(), n));
        }
    }
    sub.n_owned = static_cast<LocalIndex>(sub.particles.size());
    s.counters.migrations += left;
}

} // namespace

void rebalance(EngineState& s, bool first, double busy, double mean_busy) {
    if (!s.parallel()) return;
    const double mean = std::max(1e-12, mean_busy);
    const double imbalance = s.comm->max(busy) / mean;
    if (!first) s.counters.imbalance = imbalance;
    s.workers.timed(Phase::rebalance, 0, [&] {
        const Rebalance policy = s.model.settings.rebalance;
        // A grain's cost: this rank's busy time a grain over the mean; bounded, since one list's life can be short and noisy.
        const double share = busy / mean * static_cast<double>(s.model.n_particles) / (static_cast<double>(s.comm->size()) * std::max<double>(s.sub.n_owned, 1));
        const auto cost = first ? kCostUnits : static_cast<std::int64_t>(kCostUnits * std::clamp(share, 0.25, 4.0));
        const core::SliceGrid before = s.slices;
        if (first || policy == Rebalance::every || (policy == Rebalance::automatic && imbalance > kTolerance))
            balanced_cuts(s, cost);
        else if (policy == Rebalance::random)
            random_cuts(s);
        if (!(s.slices == before) && !first) ++s.counters.rebalances;
        migrate(s);
    });
    const std::int64_t total = s.comm->sum(static_cast<std::int64_t>(s.sub.n_owned));
    if (total != s.model.n_particles) core::fail(core::ErrorKind::internal, "step {}: {} grains after migration, {} before", s.model.step, total, s.model.n_particles);
}

} // namespace talus::runtime
