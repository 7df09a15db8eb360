#include "apps/bench/balance_study.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/balance.hpp"
#include "core/error.hpp"

namespace talus::bench {

namespace {

constexpr int kColumnsOfPart = 64;    // columns of the field along a subdomain's side
constexpr int kCoarseColumns = 16;    // ... where many rebalances are tried
constexpr double kUnits = 1000.0;     // of cost, a grain
constexpr int kMostRebalances = 10;   // from equal volumes
constexpr int kMostLimited = 2000;
constexpr double kGood = 1.05;        // max/mean that is asked for within kMostRebalances
constexpr double kLength = 1.0;       // m, side of the field: the paper's box

/// Grains in columns of a bed, seen from above: a table along x and z.
class Columns {
public:
    explicit Columns(const sandbox::Bed& bed) {
        const std::size_t n = bed.label.size();
        if (n == 0) core::fail(core::ErrorKind::argument, "the bed has no grains");
        diameter_ = 2.0 * *std::max_element(bed.radius.begin(), bed.radius.end());
        for (const int a : {0, 2}) {
            length_[a] = bed.hi[a] - bed.lo[a];
            bins_[a] = std::max(1, static_cast<int>(2.0 * length_[a] / diameter_));
        }
        count_.assign(static_cast<std::size_t>(bins_[0]) * bins_[2], 0.0);
        for (std::size_t i = 0; i < n; ++i) {
            int at[3];
            for (const int a : {0, 2}) at[a] = std::clamp(static_cast<int>((bed.position[3 * i + a] - bed.lo[a]) / length_[a] * bins_[a]), 0, bins_[a] - 1);
            count_[static_cast<std::size_t>(at[0]) * bins_[2] + at[2]] += 1.0;
        }
    }
    double length(int axis) const { return length_[axis]; }
    /// Grains in the column that (x, z) lies in, as shares of the bed's lengths: between the columns' middles in proportion.
    double at(double x, double z) const {
        const auto place = [](double share, int bins, bool wraps, int (&of)[2], double& weight) {
            const double s = share * bins - 0.5;
            const int low = static_cast<int>(std::floor(s));
            weight = s - low;
            for (int k = 0; k < 2; ++k) of[k] = wraps ? (low + k + bins) % bins : std::clamp(low + k, 0, bins - 1);
        };
        int i[2], k[2];
        double u, w;
        place(x, bins_[0], false, i, u);
        place(z, bins_[2], true, k, w);
        const auto row = [&](int r) { return count_[static_cast<std::size_t>(r) * bins_[2] + k[0]] * (1.0 - w) + count_[static_cast<std::size_t>(r) * bins_[2] + k[1]] * w; };
        return row(i[0]) * (1.0 - u) + row(i[1]) * u;
    }

private:
    double length_[3] = {}, diameter_;
    int bins_[3] = {};
    std::vector<double> count_;
};

struct Field {
    int side = 0;                    // columns along x and z
    std::vector<std::int32_t> cost;  // [side * side]
    double total = 0.0;

    /// visit(position, cost) for every column, somewhere in which it stands.
    template <class Visit>
    void each(Visit visit) const {
        const double pitch = kLength / side;
        for (int i = 0; i < side; ++i)
            for (int k = 0; k < side; ++k) {
                const std::size_t column = static_cast<std::size_t>(i) * side + k;
                if (cost[column] == 0) continue;
                // Somewhere in the column, the same place every time.
                const std::uint64_t hash = column * 0x9e3779b97f4a7c15ull;
                const double x[3] = {(i + static_cast<double>(hash >> 40) * 0x1p-24) * pitch, 0.0, (k + static_cast<double>(hash >> 16 & 0xffffff) * 0x1p-24) * pitch};
                visit(x, cost[column]);
            }
    }
};

Field make_field(const Columns& bed, const BalanceOptions& o, int side) {
    Field f;
    f.side = side;
    f.cost.resize(static_cast<std::size_t>(side) * side);
    const auto sampled = [&](int i, int k) {
        // The paper's box is kLength wide; the bed is laid in it again and again, or along x once, stretched.
        const double x = (i + 0.5) / side, z = (k + 0.5) / side;
        const double copies_x = o.whole ? 1.0 : std::max(1.0, std::round(kLength / bed.length(0))), copies_z = std::max(1.0, std::round(kLength / bed.length(2)));
        const double grains = bed.at(std::fmod(x * copies_x, 1.0), std::fmod(z * copies_z, 1.0));
        return grains * (x + 0.3 * z < 0.65 ? o.step : 1.0);
    };
    double sum = 0.0;
    for (int i = 0; i < side; ++i)
        for (int k = 0; k < side; ++k) sum += sampled(i, k);
    const double scale = kUnits * o.grains / sum;
    for (int i = 0; i < side; ++i)
        for (int k = 0; k < side; ++k) {
            const double c = std::round(sampled(i, k) * scale);
            f.cost[static_cast<std::size_t>(i) * side + k] = static_cast<std::int32_t>(c);
            f.total += c;
        }
    return f;
}

double max_over_mean(const core::SliceGrid& cuts, const Field& field) {
    std::vector<std::int64_t> cost(static_cast<std::size_t>(cuts.n_ranks()), 0);
    field.each([&](const double* x, std::int32_t c) { cost[static_cast<std::size_t>(cuts.owner(x))] += c; });
    return static_cast<double>(*std::max_element(cost.begin(), cost.end())) * cuts.n_ranks() / field.total;
}

/// One rebalance. @param out_seconds  of the balancer itself, without the field's summing up
core::SliceGrid rebalance(const core::SliceGrid& cuts, const Field& field, const core::CutLimits& limits, double& out_seconds) {
    const auto now = [] { return std::chrono::steady_clock::now(); };
    const auto from = now();
    std::chrono::duration<double> summing{0.0};
    core::SliceGrid next = core::balance(cuts, core::Box{{0.0, 0.0, 0.0}, {kLength, 0.0, kLength}}, limits, [&](core::CostProfile& profile) {
        const auto begin = now();
        field.each([&](const double* x, std::int32_t c) { profile.add(x, c); });
        summing += now() - begin;
    });
    out_seconds = (std::chrono::duration<double>(now() - from) - summing).count();
    return next;
}

} // namespace

void study_balance(const sandbox::Bed& bed, const BalanceOptions& o) {
    const Columns columns(bed);
    nlohmann::ordered_json json = nlohmann::ordered_json::array();
    fmt::print("{:.3g} grains in {} m x {} m; a rebalance moves cuts as far as they have to go\n", o.grains, kLength, kLength);
    fmt::print("subdomains  equal volumes  after 1      2      3  settled  within {}  floor of whole grains  seconds a call{}\n", kGood, o.reach > 0.0 ? "  held to a halo" : "");
    for (const int side : {8, 32, 128}) {
        const Field field = make_field(columns, o, side * kColumnsOfPart);
        core::Domain domain;
        for (int a = 0; a < 3; ++a) domain.hi[a] = kLength;
        const core::SliceGrid start(domain, {side, 1, side});
        core::SliceGrid cuts = start;
        std::vector<double> seen{max_over_mean(cuts, field)};
        double seconds = 0.0;
        for (int k = 0; k < kMostRebalances; ++k) {
            cuts = rebalance(cuts, field, {}, seconds);
            seen.push_back(max_over_mean(cuts, field));
        }
        const auto first_good = std::find_if(seen.begin(), seen.end(), [](double v) { return v <= kGood; }) - seen.begin();
        const double ranks = static_cast<double>(side) * side, floor = std::ceil(o.grains / ranks) * ranks / o.grains;
        nlohmann::ordered_json item{{"subdomains", side * side}, {"grains", o.grains}, {"max_over_mean", seen}, {"rebalances_to_1.05", first_good}, {"floor", floor}, {"seconds_a_call", seconds}};
        std::string limited;
        if (o.reach > 0.0) {
            const Field coarse = make_field(columns, o, side * kCoarseColumns); // it takes long
            core::SliceGrid held = start;
            double ignored = 0.0;
            int used = 0;
            while (used < kMostLimited && max_over_mean(held, coarse) > kGood) {
                held = rebalance(held, coarse, {0.0, o.reach}, ignored);
                ++used;
            }
            limited = used < kMostLimited ? fmt::format("  {} rebalances", used) : fmt::format("  more than {}", kMostLimited);
            item["rebalances_held_to_a_halo"] = used;
        }
        fmt::print("{:>10}  {:>13.3f}  {:>7.4f} {:>6.4f} {:>6.4f}  {:.4f}  {:>11}  {:>21.7f}  {:>14.4f}{}\n", side * side, seen[0], seen[1], seen[2], seen[3], seen.back(), fmt::format("{} moves", first_good), floor, seconds, limited);
        std::fflush(stdout);
        json.push_back(item);
    }
    if (o.json.empty()) return;
    std::ofstream out(o.json);
    out << json.dump(1) << "\n";
    out.close();
    if (!out) core::fail(core::ErrorKind::io, "{}: cannot be written", o.json);
}

} // namespace talus::bench
