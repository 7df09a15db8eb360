// migrate: grains go to their owners, any rank to any rank, with references, contacts and, where they are kept, sums.
#include <algorithm>

#include "runtime/comm/packing_buffer.hpp"
#include "runtime/phase/phases.hpp"

namespace talus::runtime {

using core::LocalIndex;
using core::Particle;

namespace {

constexpr int kBlock = 4096; // grains a task

/// Owned grains that do not lie in this rank's subdomain, in order.
std::vector<LocalIndex> find_leavers(EngineState& s) {
    const Subdomain& sub = s.sub;
    const core::Box mine = s.slices.box(s.comm->rank());
    std::vector<std::vector<LocalIndex>> parts((sub.n_owned + kBlock - 1) / kBlock);
    s.workers.for_each(Phase::rebalance, static_cast<int>(parts.size()), [&](int b) {
        const LocalIndex first = static_cast<LocalIndex>(b) * kBlock, end = std::min<LocalIndex>(sub.n_owned, first + kBlock);
        for (LocalIndex i = first; i < end; ++i) {
            const double* x = sub.particles[i].position;
            bool stays = true;
            for (int a = 0; a < 3; ++a) stays = stays && x[a] >= mine.lo[a] && x[a] < mine.hi[a];
            if (!stays) parts[static_cast<std::size_t>(b)].push_back(i);
        }
    });
    std::vector<LocalIndex> all;
    for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
}

/// Messages that take the leavers away.
std::vector<Parcel> pack(EngineState& s, const std::vector<LocalIndex>& leavers) {
    Subdomain& sub = s.sub;
    core::ContactStore& contacts = sub.contacts;
    const auto doubles = static_cast<std::size_t>(contacts.history_doubles);
    std::vector<Packer> packers(static_cast<std::size_t>(s.comm->size()));
    std::vector<core::Label> partners;
    std::vector<double> rows;
    for (const LocalIndex i : leavers) {
        Packer& p = packers[static_cast<std::size_t>(s.slices.owner(sub.particles[i].position))];
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
    }
    std::vector<Parcel> parcels;
    for (int r = 0; r < s.comm->size(); ++r)
        if (!packers[static_cast<std::size_t>(r)].empty()) parcels.push_back({r, packers[static_cast<std::size_t>(r)].take()});
    return parcels;
}

void take_in(Subdomain& sub, const Parcel& parcel) {
    std::vector<core::Label> partners;
    std::vector<double> rows;
    Unpacker u(parcel.data);
    while (!u.done()) {
        sub.particles.push_back(u.get<Particle>());
        sub.references.push_back(u.get<core::Reference>());
        if (sub.keeps_sums) sub.sums.push_back(u.get<core::ForceSum>());
        partners.resize(u.get<std::uint32_t>());
        rows.resize(partners.size() * static_cast<std::size_t>(sub.contacts.history_doubles));
        u.get_many(partners.data(), partners.size());
        u.get_many(rows.data(), rows.size());
        sub.slot_of.push_back(sub.contacts.append(partners.data(), rows.data(), static_cast<std::uint32_t>(partners.size())));
    }
}

} // namespace

void migrate(EngineState& s) {
    Subdomain& sub = s.sub;
    const std::vector<LocalIndex> leavers = find_leavers(s);
    std::vector<Parcel> parcels;
    s.workers.timed(Phase::rebalance, 0, [&] {
        parcels = pack(s, leavers);
        auto next = leavers.begin();
        if (!leavers.empty()) sub.keep_owned([&](LocalIndex i) { return next == leavers.end() || *next != i || (++next, false); });
    });
    parcels = s.comm->sparse_exchange(std::move(parcels));
    s.workers.timed(Phase::rebalance, 0, [&] {
        for (const Parcel& parcel : parcels) take_in(sub, parcel);
    });
    sub.n_owned = static_cast<LocalIndex>(sub.particles.size());
    s.counters.migrations += static_cast<std::int64_t>(leavers.size());
    const std::int64_t total = s.comm->sum(static_cast<std::int64_t>(sub.n_owned));
    if (total != s.model.n_particles) core::fail(core::ErrorKind::internal, "step {}: {} grains after migration, {} before", s.model.step, total, s.model.n_particles);
}

} // namespace talus::runtime
