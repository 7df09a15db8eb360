#include "run.hpp"

#include <chrono>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include "forecast.hpp"
#include "process_memory.hpp"
#include "settled_bed.hpp"
#include "stages.hpp"

namespace talus::sandbox {

namespace fs = std::filesystem;

namespace {

// One experiment from its input to its summary.
class Experiment {
public:
    Experiment(const Team& team, const Options& options)
        : team_(team),
          options_(options),
          input_(read_input(team, options)),
          folder_(team, options.out),
          progress_(team),
          snapshots_(folder_) {}

    ExitCode run() {
        check_paths();
        check_memory(team_, input_.config, input_.plan);
        start_ = std::chrono::steady_clock::now();
        record_.threads = input_.threads;
        // Nothing is written before the engine has accepted everything.
        const bool is_settled = make_bed();
        folder_.create();
        progress_.say(fmt::format("{}: {} {}, {} {} each", options_.config, team_.size(), team_.size() == 1 ? "rank" : "ranks",
                                  input_.threads, input_.threads == 1 ? "thread" : "threads"));
        progress_.say(plan_text(input_.config, input_.plan) + memory_text(input_.config, input_.plan, team_.size()));
        bool is_going = true;
        try {
            is_going = stages(is_settled);
            record_.status = is_going ? "done" : "stopped";
            if (input_.config.run.checkpoint) save(folder_.file("run.ckpt"));
        } catch (const Failure& failure) {
            if (failure.code() != kExitMpi) record_failure(failure);
            throw;
        }
        finish();
        return is_going ? kExitDone : kExitStopped;
    }

private:
    const Team& team_;
    const Options& options_;
    Input input_;
    OutputFolder folder_;
    Progress progress_;
    Snapshots snapshots_;
    Scene scene_;
    RunRecord record_;
    std::chrono::steady_clock::time_point start_;

    void check_paths() const {
        team_.on_root([&] {
            std::error_code error;
            if (fs::exists(options_.out, error) && !fs::is_directory(options_.out, error))
                throw Failure(kExitIo, options_.out + ": exists and is not a folder; give another --out");
            const fs::path trace_folder = fs::absolute(options_.trace, error).parent_path();
            if (!options_.trace.empty() && !fs::is_directory(trace_folder, error))
                throw Failure(kExitIo, fmt::format("{}: the folder {} does not exist", options_.trace, trace_folder.string()));
        });
    }

    std::string kept_bed() const {
        const std::string& cache = input_.config.settle.bed_cache;
        return (cache.empty() ? options_.out : cache) + "/" + settled_bed_name(input_.config, input_.plan);
    }

    // Grains in the box, lists and first forces; true if they need no settling.
    bool make_bed() {
        const Config& config = input_.config;
        const Plan& plan = input_.plan;
        const auto begin = std::chrono::steady_clock::now();
        StageRecord& stage = record_.stages.emplace_back();
        stage.name = plan.has_bed_file ? "bed" : "fill";
        bool is_settled = plan.has_bed_file;
        if (!plan.has_bed_file && config.settle.keep) is_settled = load_kept_bed(stage);
        if (scene_.engine.get() == nullptr) {
            scene_ = make_scene(team_, config, plan, input_.threads);
            if (plan.has_bed_file)
                insert_bed(scene_, config, team_, std::exchange(input_.bed, Bed{})); // it is not needed twice
            else
                fill_box(scene_, config, plan);
        }
        prepare(scene_, config);
        stage.wall_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        return is_settled;
    }

    bool load_kept_bed(StageRecord& stage) {
        const std::string path = kept_bed();
        bool exists = false;
        team_.on_root([&] { exists = fs::exists(path); });
        if (team_.from_root(std::int64_t{exists}) == 0) return false;
        std::string reason;
        if (!load_scene(team_, input_.config, input_.plan, input_.threads, path, scene_, reason)) {
            progress_.say(fmt::format("{}: this kept bed is not used: {}", path, reason));
            return false;
        }
        stage.note = "kept bed " + path;
        progress_.say(fmt::format("bed       settled before: {}", path));
        return true;
    }

    bool stages(bool is_settled) {
        Stages stages{team_, input_, scene_, folder_, progress_, snapshots_, record_};
        if (!is_settled) {
            if (!stages.settle()) {
                const talus_state state = scene_.engine.state();
                snapshots_.write(scene_, state.step, state.time, 0);
                return false;
            }
            if (input_.config.settle.keep) keep_bed();
        }
        stages.switch_friction();
        return stages.shorten(options_.trace);
    }

    void keep_bed() {
        const std::string path = kept_bed();
        team_.on_root([&] {
            std::error_code error;
            fs::create_directories(fs::path(path).parent_path(), error);
        });
        save(path);
    }

    void save(const std::string& path) const {
        scene_.engine.check(talus_checkpoint_save(scene_.engine.get(), path.c_str()), "writing a checkpoint");
    }

    void write_summary() {
        record_.wall_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
        record_.snapshots = snapshots_.records();
        folder_.write_text("summary.json", summary_text(scene_, input_.config, input_.plan, record_));
    }

    void record_failure(const Failure& failure) {
        record_.status = "failed";
        record_.error = failure.what();
        try {
            write_summary();
        } catch (const Failure&) {
            // The first failure is the one to report.
        }
    }

    void finish() {
        const talus_state state = scene_.engine.state();
        record_.ghosts = team_.largest(state.ghosts);
        record_.peak_bytes = team_.largest(static_cast<std::int64_t>(peak_bytes()));
        write_summary();
        if (state.threads_observed < input_.threads)
            progress_.say(fmt::format("note      {} threads were asked for and {} seen at work; if ranks are bound to "
                                      "processors, use mpirun --bind-to none",
                                      input_.threads, state.threads_observed));
        progress_.say(fmt::format("digest    {:016x}{:016x}  {} contacts, {} sliding", state.digest_hi, state.digest_lo,
                                  state.contacts + state.wall_contacts, state.sliding_contacts));
        progress_.say("written   " + options_.out);
    }
};

} // namespace

ExitCode run(const Team& team, const Options& options) { return Experiment(team, options).run(); }

ExitCode check(const Team& team, const Options& options) {
    const Input input = read_input(team, options);
    if (input.plan.has_bed_file) {
        check_memory(team, input.config, input.plan);
        const Scene scene = make_scene(team, input.config, input.plan, input.threads);
        insert_bed(scene, input.config, team, input.bed);
        prepare(scene, input.config);
    }
    Progress(team).say(plan_text(input.config, input.plan) + memory_text(input.config, input.plan, team.size()) + options.config + ": no faults");
    return kExitDone;
}

} // namespace talus::sandbox
