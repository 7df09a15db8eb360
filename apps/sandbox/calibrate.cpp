#include "calibrate.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>
#include <vector>

#include <fmt/format.h>

#include "process_memory.hpp"
#include "sample.hpp"
#include "scene.hpp"

namespace talus::sandbox {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::int64_t kBlock = 10;    // steps that are timed together
constexpr std::int64_t kWarmLists = 3; // lists after which the automatic skin has come near its place
constexpr std::int64_t kLists = 5;     // lists that are watched
constexpr double kWarmSeconds = 8;     // at most
constexpr double kLeastSeconds = 4, kMostSeconds = 14;
constexpr double kLeastForMemory = 20e3; // grains of a rank
constexpr double kUndisturbed = 0.95;
constexpr double kRestSeconds = 2; // without friction and at rest, where lists last

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

double median(std::vector<double> values) {
    if (values.empty()) return 0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

// Busy seconds of each phase, a mean over ranks, and the number of list rebuilds.
struct Clocks {
    std::map<std::string, double> busy;
    std::int64_t lists = 0; // grows with every rebuild
    double processor = 0;   // [s] that this process had a processor

    double since(const Clocks& before, const char* phase) const { return busy.at(phase) - before.busy.at(phase); }
};

struct Blocks {
    std::vector<double> quiet, rebuilding; // [s] that blocks took, without and with a rebuild in them
    double seconds = 0;

    std::int64_t count() const { return static_cast<std::int64_t>(quiet.size() + rebuilding.size()); }
    double step_seconds() const {
        const double all = static_cast<double>(count());
        const double mean =
            (static_cast<double>(quiet.size()) * median(quiet) + static_cast<double>(rebuilding.size()) * median(rebuilding)) / all;
        return mean / kBlock;
    }
};

class Bench {
public:
    Bench(const Team& team, const Sample& sample, const Plan& plan, std::int32_t threads, double skin) : team_(team) {
        Config config = sample.config;
        config.engine.skin = skin;
        scene_ = make_scene(team, config, plan, threads);
        const Clock::time_point start = Clock::now();
        insert_bed(scene_, config, team, sample.bed);
        set_faces(scene_, 0);
        prepare(scene_, config);
        start_seconds_ = seconds_since(start);
    }

    const Scene& scene() const { return scene_; }
    double start_seconds() const { return start_seconds_; }

    Clocks clocks() const {
        std::array<talus_phase, 16> phases{};
        talus_phase_init(phases.data());
        auto count = static_cast<std::int32_t>(phases.size());
        scene_.engine.check(talus_engine_phases(scene_.engine.get(), &count, phases.data()), "reading the phases");
        Clocks clocks;
        clocks.processor = static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
        for (std::int32_t i = 0; i < count; ++i) clocks.busy[phases[i].name] = phases[i].mean;
        for (std::int32_t i = 0; i < count; ++i)
            if (std::string(phases[i].name) == "binning") clocks.lists = team_.from_root(phases[i].calls);
        return clocks;
    }

    // Steps blocks until `is_enough`(blocks that rebuilt, all blocks, seconds), which decides on rank 0.
    template <class Enough>
    Blocks run(Enough is_enough) const {
        Blocks blocks;
        std::int64_t lists = clocks().lists;
        for (bool is_going = true; is_going;) {
            const Clock::time_point start = Clock::now();
            const talus_status status = talus_engine_step(scene_.engine.get(), kBlock, nullptr);
            const double seconds = seconds_since(start);
            scene_.engine.check(status, "calibrating");
            if (status == TALUS_STOPPED) throw Failure(kExitStopped, "calibration was stopped; nothing is stored");
            const std::int64_t now = clocks().lists;
            (now > lists ? blocks.rebuilding : blocks.quiet).push_back(seconds);
            lists = now;
            blocks.seconds += seconds;
            const bool is_done = is_enough(static_cast<std::int64_t>(blocks.rebuilding.size()), blocks.count(), blocks.seconds);
            is_going = team_.from_root(std::int64_t{is_done}) == 0;
        }
        return blocks;
    }

private:
    const Team& team_;
    Scene scene_;
    double start_seconds_ = 0;
};

std::string processor_name() {
    std::ifstream stream("/proc/cpuinfo");
    for (std::string line; std::getline(stream, line);)
        if (line.rfind("model name", 0) == 0 && line.find(": ") != std::string::npos) return line.substr(line.find(": ") + 2);
    return "unknown";
}

class Calibration {
public:
    Calibration(const Team& team, const Input& input, const std::string& scratch) : team_(team), input_(input), scratch_(scratch) {}

    Costs measure() {
        costs_.processor = processor_name();
        costs_.processors = std::max(1L, sysconf(_SC_NPROCESSORS_ONLN));
        costs_.build = talus_build_info();
        costs_.ranks = team_.size();
        costs_.laws = laws_text(input_.config.laws);
        costs_.history_doubles = history_doubles(input_.config.laws);
        sample_ = make_sample(team_, input_, [this](const std::string& line) { say(line); });
        costs_.grains = sample_.plan.grains;
        grains_ = static_cast<double>(costs_.grains) / team_.size();
        if (sample_.column) costs_.settling = sample_.column->settling;
        give_memory_back(); // what reading or settling left must not count as the sample's
        costs_.runs.push_back(measure(input_.threads));
        if (input_.threads > 1) costs_.runs.insert(costs_.runs.begin(), measure(1));
        return costs_;
    }

private:
    const Team& team_;
    const Input& input_;
    const std::string& scratch_;
    Sample sample_;
    double grains_ = 0; // a rank
    double skin_ = 0;   // [m] once known, so that later runs need not find it
    Costs costs_;

    void say(const std::string& line) const {
        if (team_.is_root()) fmt::print(stderr, "calibrating: {}\n", line);
    }

    RunCosts measure(std::int32_t threads) {
        RunCosts run;
        run.threads = threads;
        say(fmt::format("{} grains at rest, {} {}", costs_.grains, threads, threads == 1 ? "thread" : "threads"));
        if (!input_.plan.has_bed_file) run.settle = settling(threads);
        say(fmt::format("the same with friction, walls at {:g} m/s", input_.config.shorten.speed));
        shortening(run);
        return run;
    }

    // The sample at rest tells what 200,000 grains cost beside the few thousand of the column, the column what settling costs
    // beside rest: falling grains have few contacts, landing ones many rebuilds.
    StageCosts settling(std::int32_t threads) const {
        const Bench bench(team_, sample_, sample_.settling_plan(), threads, skin_);
        const Blocks blocks = bench.run([](std::int64_t, std::int64_t, double seconds) { return seconds > kRestSeconds; });
        StageCosts settle;
        settle.particle_steps_per_second = grains_ / blocks.step_seconds();
        settle.steps_per_rebuild =
            static_cast<double>(blocks.count() * kBlock) / std::max<double>(1, static_cast<double>(blocks.rebuilding.size()));
        if (sample_.column) settle.particle_steps_per_second *= sample_.column->speed / sample_.column->speed_at_rest;
        return settle;
    }

    void shortening(RunCosts& run) {
        const bool is_first = skin_ == 0;
        double stepping = 0, saving = 0; // peaks of resident bytes
        {
            const Bench bench(team_, sample_, sample_.shortening_plan(), run.threads, is_first ? sample_.config.engine.skin : skin_);
            start_moving(bench.scene());
            forget_peak();
            bench.run([&](std::int64_t lists, std::int64_t, double seconds) {
                return lists >= (is_first ? kWarmLists : 1) || seconds > kWarmSeconds;
            });
            const Clocks before = bench.clocks();
            const Blocks blocks = bench.run([](std::int64_t lists, std::int64_t, double seconds) {
                return (lists >= kLists && seconds > kLeastSeconds) || seconds > kMostSeconds;
            });
            const Clocks after = bench.clocks();
            const talus_state state = bench.scene().engine.state();
            summarise(run, blocks, before, after, static_cast<double>(team_.largest(state.ghosts)));
            if (is_first) {
                skin_ = state.skin;
                costs_.skin_diameters = state.skin / (2 * sample_.plan.radius_max);
                costs_.contacts_per_grain = static_cast<double>(state.contacts) / static_cast<double>(state.particles);
                costs_.start_seconds_per_grain = bench.start_seconds() / grains_;
                stepping = peak_bytes();
                save(bench.scene());
                saving = peak_bytes();
            }
        }
        if (is_first) measure_memory(stepping, saving);
    }

    // From the level without the engine. What the allocator keeps of it counts as base, so small samples tell nothing.
    void measure_memory(double stepping, double saving) {
        give_memory_back();
        const double without = resident_bytes();
        constexpr std::size_t kOfGrain = sizeof(std::int64_t) + 4 * sizeof(double);
        const double of_beds =
            static_cast<double>(sample_.bed.label.size() * (kOfGrain + sizeof(std::int32_t)) + input_.bed.label.size() * kOfGrain);
        costs_.memory = reference_memory(costs_);
        if (without <= of_beds || grains_ < kLeastForMemory) return;
        costs_.memory = {(stepping - without) / grains_, (saving - without) / grains_, without - of_beds, true};
    }

    void start_moving(const Scene& scene) const {
        const Config::Shorten& shorten = input_.config.shorten;
        // Sand that rides on the floor has its speed after the ramp.
        const bool rides = shorten.start == kStartCoMoving || (shorten.start == kStartRamp && shorten.moving.floor);
        const double velocity[3] = {shorten.speed, 0, 0};
        if (rides) scene.engine.check(talus_particles_add_velocity(scene.engine.get(), velocity), "starting the sand");
        set_wall_speed(scene, shorten.speed);
        set_faces(scene, shorten.moving.front ? shorten.speed : 0);
    }

    void summarise(RunCosts& run, const Blocks& blocks, const Clocks& before, const Clocks& after, double ghosts) const {
        const double steps = static_cast<double>(blocks.count() * kBlock);
        const double lists = static_cast<double>(blocks.rebuilding.size());
        run.shorten.particle_steps_per_second = grains_ / blocks.step_seconds();
        run.shorten.steps_per_rebuild = steps / std::max(1.0, lists);
        const auto busy = [&](const char* phase, double items) { return items > 0 ? after.since(before, phase) / items : 0; };
        run.busy.force = busy("force", grains_ * steps);
        run.busy.integrate = busy("integrate", grains_ * steps);
        if (ghosts > 0) run.busy.halo_exchange = busy("halo_exchange", ghosts * steps);
        run.busy.binning = busy("binning", grains_ * lists);
        run.busy.pair_build = busy("pair_build", grains_ * lists);
        run.busy.rebalance = busy("rebalance", grains_ * lists);
        double all = 0;
        for (const auto& [phase, seconds] : after.busy) all += seconds - before.busy.at(phase);
        // Phases are timed by the clock on the wall; who waits for a processor in one is busy by it.
        if (const double had = (after.processor - before.processor) / all; had < kUndisturbed)
            say(fmt::format(
                "NOTE: other work had {:.0f} % of the processors' time; these costs are too high, measure again when it is quiet",
                100 * (1 - had)));
        run.idle_share = std::clamp(1 - all / (run.threads * blocks.seconds), 0.0, 1.0);
    }

    void save(const Scene& scene) {
        const Clock::time_point start = Clock::now();
        scene.engine.check(talus_checkpoint_save(scene.engine.get(), scratch_.c_str()), "writing a checkpoint");
        const double seconds = seconds_since(start);
        team_.on_root([&] {
            std::error_code error;
            costs_.write_bytes_per_second = static_cast<double>(std::filesystem::file_size(scratch_, error)) / seconds;
            std::filesystem::remove(scratch_, error);
        });
    }
};

} // namespace

Costs calibrate(const Team& team, const Input& input, const std::string& scratch) { return Calibration(team, input, scratch).measure(); }

} // namespace talus::sandbox
