#include "core/kernel_impl.hpp"

#include "apps/bench/flops.hpp"
#include "runtime/phase/phases.hpp"

namespace talus::bench {

namespace {

using core::ContactState;
using core::Vec3;

/// Any sound contact will do: laws choose, they do not branch.
struct CountLaw {
    template <class Law>
    static LawOperations make() {
        const auto one = [](double a) { return core::splat<Counted>(a); };
        const auto vector = [&](double x, double y, double z) { return Vec3<Counted>{one(x), one(y), one(z)}; };
        const core::Periods periods{core::Domain{}};
        const Vec3<Counted> xi = vector(0.0, 0.0, 0.0), xj = vector(1.9, 0.1, 0.0), vi = vector(0.1, 0.2, 0.3), vj = vector(0.0, -0.1, 0.0), wi = vector(1.0, 2.0, 3.0), wj = vector(0.0, 1.0, -1.0);
        const Counted radius = one(1.0), mass = one(1.0);
        const core::ContactParameters<Counted> parameters{one(1e3), one(1e3), one(1.0), one(1.0), one(0.5), one(0.1), one(0.3)};
        const core::StepConstants<Counted> constants{one(1e-3), one(0.0), one(1e-3)};
        ContactState<Counted> x;
        x.history = {{vector(0.0, 0.1, 0.1), one(0.3)}, vector(0.0, 0.0, 0.1)};

        LawOperations counts;
        const auto part = [&](std::string name, auto body) { counts.parts.push_back({std::move(name), count(body)}); };
        counts.candidate = count([&] { core::touches(periods, xi, radius, xj, radius); });
        part("overlap", [&] { core::set_overlap(periods, xi, radius, xj, radius, x.geometry); });
        part("approach", [&] { core::set_approach(vi, vj, x.geometry); });
        part("spin", [&] { core::set_spin(wi, radius, wj, radius, x.geometry); });
        part("scales", [&] { core::set_scales<Law::kNeedsInertia>(radius, mass, radius, mass, false, x.geometry); });
        Law::template stages<Counted, false>(constants, [&](auto stage) { part("", [&] { stage(x, parameters); }); });
        return counts;
    }
};

std::vector<const char*> stage_names(const core::Laws& laws) {
    std::vector<const char*> names{"normal"};
    const bool tangential = laws.tangential != core::TangentialLaw::none, spring = laws.rolling == core::RollingLaw::spring;
    if (tangential || laws.rolling != core::RollingLaw::none) names.push_back(laws.rolling == core::RollingLaw::constant ? "springs carry, rolling" : "springs carry");
    if (tangential || spring) names.push_back("springs hold");
    return names;
}

// Kernels are plain functions: what they count stands here. One engine is counted at a time.
core::KernelSet counting;
ForceOperations found;

template <class... With>
using Kernel = void (*)(With...);
template <class... With>
Kernel<With...> counted_pairs(Kernel<With...>) {
    return [](With... with) { found.pairs += count([&] { counting.pair(with...); }); };
}
template <class... With>
Kernel<With...> counted_walls(Kernel<With...>) {
    return [](With... with) { found.walls += count([&] { counting.wall(with...); }); };
}

} // namespace

Operations LawOperations::contact() const {
    Operations sum;
    for (const Part& p : parts) sum += p.operations;
    return sum;
}

LawOperations count_law(const core::Laws& laws) {
    LawOperations counts = core::choose_law<CountLaw>(laws);
    const auto names = stage_names(laws);
    const std::size_t first = counts.parts.size() - names.size();
    for (std::size_t k = 0; k < names.size(); ++k) {
        if (!counts.parts[first + k].name.empty()) core::fail(core::ErrorKind::internal, "the stages of the law are not those that have names here");
        counts.parts[first + k].name = names[k];
    }
    return counts;
}

ForceOperations count_forces(runtime::EngineState& s) {
    runtime::refresh_contexts(s);
    const core::KernelSet own = s.kernels;
    counting = core::kernel::choose<Counted>(s.model.settings.laws, false);
    found = {};
    s.kernels = {counted_pairs(counting.pair), counted_walls(counting.wall)};
    s.force.advance = false;
    s.with_forces = true;
    s.workers.arena().execute([&] {
        for (int t = 0; t < static_cast<int>(s.sub.tiles.size()); ++t) runtime::force_tile(s, t);
    });
    for (core::Tile& tile : s.sub.tiles) core::collect_border(s.sub.tiles, tile);
    s.force.advance = true;
    s.kernels = own;
    return found;
}

} // namespace talus::bench
