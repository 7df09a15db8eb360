#include "forecast.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "config_keys.hpp"
#include "failure.hpp"
#include "settled_bed.hpp"

namespace talus::sandbox {

namespace {

constexpr double kGhostBytes = 96;   // twelve doubles a ghost and step (runtime/comm/halo.cpp), and a chunk
constexpr double kTileGrains = 1024; // when [engine] tile_grains is 0
constexpr double kImbalance = 1.04;  // largest over mean load (core/balance.hpp: kGoodEnough), up to which subdomains are left as they are
constexpr double kGhostWork = 0.25;  // of a grain: its contacts with own grains are evaluated on both ranks

// Checkpoints (runtime/io/checkpoint_layout.hpp): columns of a grain with the ones that ParaView needs, a contact at both of
// its grains. Snapshots (runtime/io/snapshot.cpp).
constexpr double kCheckpointGrain = 192;
constexpr double kCheckpointContact = 8; // and 8 a double of history
constexpr double kCheckpointHead = 64e3;
constexpr double kSnapshotGrain = 85;
constexpr double kSnapshotHead = 24e3;
// walls.csv: numbers with all digits; step and time, and of a wall three forces and a place that has one of its own.
constexpr double kWallsRow = 30, kWallsWall = 82;

// Settling by rule of thumb, by the free fall of the fill's top: fitted to four columns of sand, 19 to 83 diameters deep, that came to
// rest at kinetic = 2e-3 to 1e-5, and within a third of them.
constexpr double kSettleFalls = 1.1, kSettleDecay = 0.55, kSettleKinetic = 3e-3;

double share_of(double grains, std::int32_t ranks) { return grains / ranks * (ranks > 1 ? kImbalance : 1); }

FilesForecast files_of(const Config& config, const Plan& plan, const Costs& costs) {
    FilesForecast files;
    const double grains = static_cast<double>(plan.grains);
    const double contacts = 2 * costs.contacts_per_grain * grains;
    const auto checkpoint = [&](int doubles) {
        return kCheckpointHead + kCheckpointGrain * grains + (kCheckpointContact + 8.0 * doubles) * contacts;
    };
    if (!plan.has_bed_file && config.settle.keep) files.settled_bed = checkpoint(0);
    const std::int64_t during = config.run.checkpoint_every > 0 ? plan.shorten_steps / config.run.checkpoint_every : 0;
    files.checkpoints = during + (config.run.checkpoint ? 1 : 0);
    if (files.checkpoints > 0) files.checkpoint = checkpoint(history_doubles(config.laws));

    // One at the start, one at each multiple of the interval, and one at the end if none was due there.
    files.snapshots = 1;
    std::int64_t last = 0;
    for (std::int64_t n = 1; last < plan.shorten_steps; ++n) {
        const std::int64_t due = plan.snapshot_step(n);
        if (due > plan.shorten_steps) break;
        // An interval shorter than a step gives one snapshot a step.
        if (due > last) ++files.snapshots;
        last = due;
    }
    if (last != plan.shorten_steps) ++files.snapshots;
    files.snapshot = kSnapshotHead + kSnapshotGrain * grains;

    const double walls = config.box.periodic_z ? 3 : 5;
    const double rows = 1 + std::ceil(static_cast<double>(plan.shorten_steps) / static_cast<double>(config.run.walls_every));
    files.walls = (kWallsRow + kWallsWall * walls) * rows;

    const double snapshots = files.snapshot * static_cast<double>(files.snapshots);
    // Of checkpoints the one before the last is kept.
    files.on_disk =
        files.settled_bed + files.checkpoint * static_cast<double>(std::min<std::int64_t>(files.checkpoints, 2)) + snapshots + files.walls;
    files.written = files.settled_bed + files.checkpoint * static_cast<double>(files.checkpoints) + snapshots + files.walls;
    return files;
}

struct SettleSteps {
    std::int64_t steps;
    bool is_measured;
};

SettleSteps settle_steps(const Config& config, const Plan& plan, const Costs& costs) {
    const std::int64_t cap = plan.settle_cap(config);
    const double decay = std::max(0.0, std::log(kSettleKinetic / config.settle.kinetic));
    const double by_rule = std::ceil(plan.fall_time * (kSettleFalls + kSettleDecay * decay) / plan.step);
    std::int64_t steps = std::min(static_cast<std::int64_t>(by_rule), cap);
    if (!costs.settling || costs.settling->key != settling_key(config)) return {steps, false};
    // A column that was given up tells at least how many steps do not suffice.
    const Settling& column = *costs.settling;
    steps = std::min(column.is_at_rest ? column.steps : std::max(column.steps, steps), cap);
    return {steps, column.is_at_rest || column.steps >= cap};
}

class Forecaster {
public:
    Forecaster(const Config& config, const Plan& plan, const Costs& costs, const Machine& machine)
        : config_(config), plan_(plan), costs_(costs), run_(costs.run(machine.threads)) {
        out_.machine = machine;
        if (!(out_.machine.write_bytes_per_second > 0)) out_.machine.write_bytes_per_second = costs.write_bytes_per_second;
    }

    Forecast make() {
        out_.halo = halo_of(config_, plan_, out_.machine.ranks, costs_.skin_diameters);
        out_.rank_grains = share_of(static_cast<double>(plan_.grains), out_.machine.ranks);
        out_.rank_bytes = rank_bytes(costs_, config_, out_.rank_grains + out_.halo.ghosts);
        const double mean = static_cast<double>(plan_.grains) / out_.machine.ranks + out_.halo.ghosts;
        out_.bytes = rank_bytes(costs_, config_, mean) * out_.machine.ranks;
        out_.files = files_of(config_, plan_, costs_);
        times();
        assumptions();
        return out_;
    }

private:
    const Config& config_;
    const Plan& plan_;
    const Costs& costs_;
    const RunCosts& run_;
    Forecast out_;

    StageForecast stage(std::int64_t steps, const StageCosts& cost) const {
        // Threads that nobody measured are taken to be as good as those that were.
        const double speed = cost.particle_steps_per_second * out_.machine.threads / run_.threads;
        const Halo& halo = out_.halo;
        double packing = 0, network = 0;
        if (out_.machine.ranks > 1) {
            packing = halo.ghosts * run_.busy.halo_exchange.value_or(*reference_costs().run(1).busy.halo_exchange);
            network = halo.messages * out_.machine.latency + halo.bytes / out_.machine.bandwidth;
        }
        const double compute = (out_.rank_grains + kGhostWork * halo.ghosts) / speed;
        const double n = static_cast<double>(steps);
        return {steps, n * (compute + packing + network), n * network};
    }

    void times() {
        out_.start_seconds = costs_.start_seconds_per_grain * out_.rank_grains;
        if (!plan_.has_bed_file) {
            const SettleSteps settling = settle_steps(config_, plan_, costs_);
            out_.settling_is_measured = settling.is_measured;
            out_.settle = stage(settling.steps, run_.settle.value_or(run_.shorten));
        }
        out_.shorten = stage(plan_.shorten_steps, run_.shorten);
        out_.file_seconds = out_.files.written / out_.machine.write_bytes_per_second;
        out_.seconds = out_.start_seconds + out_.settle.seconds + out_.shorten.seconds + out_.file_seconds;
    }

    void assume(std::string text) { out_.assumptions.push_back(std::move(text)); }

    void assumptions() {
        const Machine& m = out_.machine;
        if (!plan_.has_bed_file)
            assume(out_.settling_is_measured ? "Settling takes as many steps as it took in the calibrated column of this sand."
                                             : "Settling takes the steps of a rule of thumb, fitted to four columns of sand: right within "
                                               "a half at best, and the cap bounds it.");
        if (!plan_.has_bed_file && !run_.settle) assume("Settling steps as fast as shortening: costs were measured with a bed file.");
        if (costs_.laws != laws_text(config_.laws))
            assume(fmt::format("Times are those of other laws ({}); memory and files are corrected for the histories of these ({}).",
                               costs_.laws, laws_text(config_.laws)));
        if (run_.threads != m.threads)
            assume(fmt::format("{} threads are {:.3g} times as fast as the {} that were measured.", m.threads,
                               static_cast<double>(m.threads) / run_.threads, run_.threads));
        assume(fmt::format("Each rank has {} of its own, as fast as the one measured{}.",
                           m.threads == 1 ? "a processor" : fmt::format("{} processors", m.threads),
                           m.ranks > costs_.ranks ? " and with its share of the memory bandwidth" : ""));
        if (m.ranks > 1) {
            assume(fmt::format("The fullest rank has {:g} times the mean load; a ghost costs {:g} of a grain's step, and its packing.",
                               kImbalance, kGhostWork));
            assume(fmt::format(
                "Messages take {:g} us each and {:g} GB/s a rank, and nothing of it is hidden behind work (Talus hides most of it).",
                1e6 * m.latency, 1e-9 * m.bandwidth));
            if (!run_.busy.halo_exchange) assume("Packing of ghosts is a reference value, not measured here: calibrate under mpirun -n 2.");
        }
        assume(fmt::format("Files are written at {:.3g} MB/s by all ranks together, {}.", 1e-6 * m.write_bytes_per_second,
                           m.write_bytes_per_second == costs_.write_bytes_per_second ? "as one rank did when costs were measured"
                                                                                     : "as stated"));
        assume("Memory is the most while stepping, rebuilding lists and writing files; a ghost takes as much as a grain.");
        if (!costs_.memory.is_measured && !costs_.is_built_in())
            assume("Memory a grain is a built-in value: it needs a sample of 20,000 grains to be measured.");
    }
};

} // namespace

Halo halo_of(const Config& config, const Plan& plan, std::int32_t ranks, double skin_diameters) {
    Halo halo;
    const std::array<double, 3> sand{plan.length(), plan.depth, plan.width()};
    const std::array<std::int32_t, 3> periodic{0, 0, config.box.periodic_z ? 1 : 0};
    std::array<std::int32_t, 3> given{};
    for (int axis = 0; axis < 3; ++axis) given[axis] = static_cast<std::int32_t>(config.engine.rank_grid[axis]);
    if (talus_rank_grid(sand.data(), periodic.data(), ranks, given.data(), halo.grid.data()) != TALUS_OK)
        throw Failure(kExitInput,
                      fmt::format("{}: {}: {}", where(config, "engine.rank_grid"), subject(config, "engine.rank_grid"), talus_message()));

    const double skin = config.engine.skin > 0 ? config.engine.skin : skin_diameters * 2 * plan.radius_max;
    const double reach = 2 * plan.radius_max + skin;
    const double density = static_cast<double>(plan.grains) / (sand[0] * sand[1] * sand[2]);
    const double tile_grains = config.engine.tile_grains > 0 ? static_cast<double>(config.engine.tile_grains) : kTileGrains;
    const double tile = std::cbrt(tile_grains / density);
    double own = 1, with_shell = 1, tiles = 1, with_border = 1, ranks_near = 1;
    for (int axis = 0; axis < 3; ++axis) {
        const std::int32_t parts = halo.grid[axis];
        const bool is_periodic = axis == 2 && config.box.periodic_z;
        const double size = halo.size[axis] = sand[axis] / parts;
        const double sides = parts == 1 ? 0 : parts == 2 && !is_periodic ? 1 : 2;
        if (const double room = (plan.hi[axis] - plan.lo[axis]) / parts; parts > 1 && room < 2 * plan.radius_max + plan.skin)
            throw Failure(kExitInput,
                          fmt::format("{} ranks: {} subdomains along {} would be {:.3g} m wide, less than grain and skin, {:.3g} m; "
                                      "use fewer ranks or give another engine.rank_grid",
                                      ranks, parts, "xyz"[axis], room, 2 * plan.radius_max + plan.skin));
        own *= size;
        with_shell *= size + sides * reach;
        const double across = std::max(1.0, size / tile);
        tiles *= across;
        with_border *= across + sides;
        ranks_near *= 1 + std::min(sides, parts - 1.0);
    }
    halo.ghosts = density * (with_shell - own);
    halo.messages = ranks_near - 1;
    halo.bytes = kGhostBytes * (halo.ghosts + with_border - tiles);
    return halo;
}

Forecast make_forecast(const Config& config, const Plan& plan, const Costs& costs, const Machine& machine) {
    return Forecaster(config, plan, costs, machine).make();
}

double expected_rank_bytes(const Config& config, const Plan& plan, std::int32_t ranks) {
    const Costs costs = reference_costs();
    const double ghosts = ranks > 1 ? halo_of(config, plan, ranks, costs.skin_diameters).ghosts : 0;
    return rank_bytes(costs, config, share_of(static_cast<double>(plan.grains), ranks) + ghosts);
}

} // namespace talus::sandbox
