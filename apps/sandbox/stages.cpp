#include "stages.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include <fmt/format.h>

namespace talus::sandbox {

namespace {

constexpr std::int64_t kMostStepsPerCall = 1000; // so that progress is told; changes no bits
constexpr std::int64_t kTraceFrom = 100;         // steps of the shortening stage before the traced ones
constexpr std::int64_t kTraceSteps = 200;
constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();
constexpr double kLeastContacts = 1.5; // of each grain with grains, in a bed; a falling cloud has none

class Stopwatch {
public:
    double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

std::int64_t next_multiple(std::int64_t step, std::int64_t every) { return every > 0 ? step - step % every + every : kNever; }

// Measured only where there is something to balance: it costs about a force evaluation.
double imbalance_of(const Team& team, const Scene& scene) { return team.size() > 1 ? scene.engine.state().imbalance : 0; }

} // namespace

Rest rest_of(const Config& config, const Plan& plan, const talus_state& state) {
    const double diameter = std::cbrt(6 / std::numbers::pi * plan.grain_volume);
    const double energy_unit = plan.grain_mass * config.box.gravity * diameter * static_cast<double>(plan.grains);
    Rest rest;
    rest.kinetic = state.kinetic_energy / energy_unit;
    rest.unbalanced = state.unbalanced_force;
    rest.is_reached = rest.kinetic < config.settle.kinetic && rest.unbalanced < config.settle.unbalanced &&
                      static_cast<double>(state.contacts) > kLeastContacts * static_cast<double>(state.particles);
    return rest;
}

bool Stages::advance(std::int64_t steps, StageRecord& stage, const char* doing) {
    const Stopwatch watch;
    std::int64_t done = 0;
    const talus_status status = talus_engine_step(scene.engine.get(), steps, &done);
    stage.stepping_seconds += watch.seconds();
    stage.steps += done;
    stage.time = static_cast<double>(stage.steps) * input.plan.step;
    if (status < 0) scene.engine.check(status, fmt::format("{}, after step {} ({:.6g} s)", doing, stage.steps, stage.time));
    return status != TALUS_STOPPED;
}

bool Stages::settle() {
    const Config::Settle& config = input.config.settle;
    const Plan& plan = input.plan;
    const Stopwatch watch;
    StageRecord& stage = record.stages.emplace_back();
    stage.name = "settle";
    const std::int64_t cap = plan.settle_cap(input.config);

    progress.begin(stage.name, plan.grains, 0);
    bool is_going = true;
    bool is_at_rest = false;
    while (is_going && !is_at_rest && stage.steps < cap) {
        const std::int64_t until = std::min(cap, next_multiple(stage.steps, config.check_every));
        is_going = advance(std::min(until - stage.steps, kMostStepsPerCall), stage, "settling");
        const bool is_due = progress.is_due();
        const bool is_checked = stage.steps % config.check_every == 0 && stage.time >= plan.fall_time;
        if (!is_due && !is_checked) continue;
        const talus_state state = scene.engine.state();
        const Rest rest = rest_of(input.config, plan, state);
        is_at_rest = is_checked && rest.is_reached;
        if (is_due)
            progress.show(stage.steps,
                          fmt::format("{:.4f} s  kinetic {:.1e} of {:.0e}  unbalanced {:.1e} of {:.0e}", stage.time, rest.kinetic,
                                      config.kinetic, rest.unbalanced, config.unbalanced),
                          state.ranks > 1 ? state.imbalance : 0);
    }
    stage.wall_seconds = watch.seconds();
    stage.note = is_at_rest ? "at rest" : is_going ? "not at rest at the cap" : "stopped";
    progress.end(fmt::format("{:.4f} s in {} steps, {}: {}", stage.time, stage.steps, duration_text(stage.wall_seconds), stage.note));
    return is_going;
}

void Stages::switch_friction() {
    const Stopwatch watch;
    const Config& config = input.config;
    const Plan& plan = input.plan;
    talus_engine* engine = scene.engine.get();
    StageRecord& stage = record.stages.emplace_back();
    stage.name = "friction";
    if (config.box.level && !plan.has_bed_file) {
        std::int64_t removed = 0;
        scene.engine.check(talus_particles_remove_above(engine, 1, plan.lo[1] + config.box.depth, &removed), "levelling");
        stage.note = fmt::format("{} grains above {:g} m taken away", removed, config.box.depth);
        progress.say("level     " + stage.note);
    }
    if (!plan.has_bed_file) switch_friction_on(scene, config);
    scene.engine.check(talus_particles_colour_layers(engine, 1, plan.lo[1], config.layers.thickness), "colouring layers");
    scene.engine.check(talus_particles_mark_reference(engine), "marking the reference");
    stage.wall_seconds = watch.seconds();
}

bool Stages::shorten(const std::string& trace) {
    const Config& config = input.config;
    const Plan& plan = input.plan;
    const Shortening& motion = plan.shortening;
    const Stopwatch watch;
    StageRecord& stage = record.stages.emplace_back();
    stage.name = "shorten";

    WallSeries walls(team, folder, scene);
    std::optional<EnergySeries> energy;
    if (config.engine.energy_ledger) energy.emplace(team, folder);
    // Series and snapshots tell the engine's clock, which snapshots and checkpoints hold; it includes settling.
    const talus_state start = scene.engine.state();
    record.shorten_start_step = start.step;
    record.shorten_start_time = start.time;
    std::int64_t last_row = -1;
    std::int64_t last_snapshot = -1;
    const auto add_row = [&] {
        last_row = stage.steps;
        walls.add(scene, start.step + stage.steps, start.time + stage.time);
        if (energy) energy->add(scene, start.step + stage.steps, start.time + stage.time);
    };
    const auto add_snapshot = [&] {
        last_snapshot = stage.steps;
        snapshots.write(scene, start.step + stage.steps, start.time + stage.time, motion.travel(stage.steps));
    };

    if (config.shorten.start == kStartCoMoving) {
        const double velocity[3] = {motion.speed(), 0, 0};
        scene.engine.check(talus_particles_add_velocity(scene.engine.get(), velocity), "starting the sand");
    }
    set_wall_speed(scene, motion.velocity(0));
    progress.begin(stage.name, plan.grains, plan.shorten_steps);
    add_snapshot();
    add_row();

    std::int64_t next_speed = motion.next_change(0);
    std::int64_t next_snapshot = plan.snapshot_step(1);
    std::int64_t snapshot_number = 1;
    const std::int64_t trace_steps = std::min(kTraceSteps, plan.shorten_steps);
    std::int64_t next_trace = trace.empty() ? kNever : std::min(kTraceFrom, plan.shorten_steps - trace_steps);
    bool is_going = true;
    while (is_going && stage.steps < plan.shorten_steps) {
        if (stage.steps == next_trace) {
            scene.engine.check(talus_trace_start(scene.engine.get(), trace.c_str(), trace_steps), trace);
            next_trace = kNever;
        }
        const std::int64_t until =
            std::min({plan.shorten_steps, next_multiple(stage.steps, config.run.walls_every), next_snapshot, next_speed, next_trace,
                      next_multiple(stage.steps, config.run.checkpoint_every), stage.steps + kMostStepsPerCall});
        is_going = advance(until - stage.steps, stage, "shortening");
        if (stage.steps % config.run.walls_every == 0) add_row();
        if (stage.steps >= next_snapshot) {
            add_snapshot();
            // An interval shorter than a step still gives one snapshot a step.
            while (next_snapshot <= stage.steps) next_snapshot = plan.snapshot_step(++snapshot_number);
        }
        if (stage.steps >= next_speed) {
            set_wall_speed(scene, motion.velocity(stage.steps));
            next_speed = motion.next_change(stage.steps);
        }
        const std::string path = folder.file("run.ckpt");
        if (config.run.checkpoint_every > 0 && stage.steps % config.run.checkpoint_every == 0)
            scene.engine.check(talus_checkpoint_save(scene.engine.get(), path.c_str()), "writing a checkpoint");
        if (progress.is_due())
            progress.show(stage.steps,
                          fmt::format("{:.4f} s  {:.3f} of {:.4g} mm", stage.time, 1e3 * motion.travel(stage.steps),
                                      1e3 * motion.travel(plan.shorten_steps)),
                          imbalance_of(team, scene));
    }
    if (last_row != stage.steps) add_row();
    if (last_snapshot != stage.steps) add_snapshot();
    record.shorten_steps = stage.steps;
    stage.wall_seconds = watch.seconds();
    stage.note = is_going ? "" : "stopped";
    progress.end(fmt::format("{:.4g} mm in {:.4g} s, {} steps, {}{}", 1e3 * motion.travel(stage.steps), stage.time, stage.steps,
                             duration_text(stage.wall_seconds), is_going ? "" : ": stopped"));
    return is_going;
}

} // namespace talus::sandbox
