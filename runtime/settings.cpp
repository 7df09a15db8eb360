#include "runtime/settings.hpp"

#include <cmath>

#include <fmt/format.h>

#include "core/slice_grid.hpp"

namespace talus::runtime {

namespace {

class Faults {
public:
    template <class... Args>
    void add(fmt::format_string<Args...> format, Args&&... args) {
        if (!text_.empty()) text_ += '\n';
        text_ += fmt::format(format, std::forward<Args>(args)...);
    }
    std::string take() { return std::move(text_); }

private:
    std::string text_;
};

} // namespace

std::string laws_faults(const core::Laws& l) {
    Faults f;
    const auto in_range = [&](const char* name, int v, int last) {
        if (v < 0 || v > last) f.add("laws.{} = {}: not one of 0..{}", name, v, last);
    };
    in_range("normal", static_cast<int>(l.normal), 1);
    in_range("damping", static_cast<int>(l.damping), 1);
    in_range("tangential", static_cast<int>(l.tangential), 3);
    in_range("rolling", static_cast<int>(l.rolling), 2);
    in_range("rolling_radius", static_cast<int>(l.rolling_radius), 1);
    std::string text = f.take();
    if (text.empty())
        if (const char* fault = core::laws_fault(l)) text = fmt::format("laws: {}", fault);
    return text;
}

std::string settings_faults(const Settings& s, int n_ranks) {
    Faults f;
    constexpr char kAxis[] = "xyz";
    for (int a = 0; a < 3; ++a) {
        const double lo = s.domain.lo[a], hi = s.domain.hi[a];
        if (!std::isfinite(lo) || !std::isfinite(hi))
            f.add("domain_lo/hi {} = {}, {}: not finite; give the box of the simulation [m]", kAxis[a], lo, hi);
        else if (!(lo < hi))
            f.add("domain_lo/hi {} = {}, {}: the upper end must be above the lower one", kAxis[a], lo, hi);
        if (!std::isfinite(s.gravity[a])) f.add("gravity {} = {}: not finite [m/s^2]", kAxis[a], s.gravity[a]);
        if (s.rank_grid[a] < 0) f.add("rank_grid {} = {}: must be > 0, or 0 to choose", kAxis[a], s.rank_grid[a]);
    }
    if (s.threads < 1 || s.threads > kMaxThreads) f.add("threads = {}: must be 1..{}", s.threads, kMaxThreads);
    if (!(s.time_step > 0.0) || !std::isfinite(s.time_step)) f.add("time_step = {}: must be > 0 [s]; 0.1 to 0.2 of talus_engine_critical_step() is usual", s.time_step);
    if (!(s.time_step_limit > 0.0) || !(s.time_step_limit <= 1.0)) f.add("time_step_limit = {}: must be in (0, 1], a fraction of the Rayleigh step", s.time_step_limit);
    if (!(s.skin >= 0.0) || !std::isfinite(s.skin)) f.add("skin = {}: must be >= 0 [m]; 0 chooses", s.skin);
    if (!(s.radius_max >= 0.0) || !std::isfinite(s.radius_max)) f.add("radius_max = {}: must be >= 0 [m]; 0 takes the largest grain at the first step", s.radius_max);
    if (s.tile_grains < 0) f.add("tile_grains = {}: must be >= 0; 0 chooses", s.tile_grains);
    if (static_cast<int>(s.rebalance) < 0 || static_cast<int>(s.rebalance) > 3) f.add("rebalance = {}: not one of 0..3", static_cast<int>(s.rebalance));
    if (s.rebalance_interval < 1) f.add("rebalance_interval = {}: must be >= 1, a number of rebuilds", s.rebalance_interval);
    std::string text = f.take();
    if (text.empty()) {
        const double lengths[3] = {s.domain.length(0), s.domain.length(1), s.domain.length(2)};
        if (core::choose_rank_grid(n_ranks, lengths, s.domain.periodic, s.rank_grid)[0] == 0)
            text = fmt::format("rank_grid = {} {} {}: its product must be the number of ranks, {} (0 leaves an axis to the library)", s.rank_grid[0], s.rank_grid[1], s.rank_grid[2], n_ranks);
    }
    if (const std::string laws = laws_faults(s.laws); !laws.empty()) text += (text.empty() ? "" : "\n") + laws;
    return text;
}

} // namespace talus::runtime
