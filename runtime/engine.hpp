// runtime/engine.hpp: the facade of one simulation: set up, step, observe, save. The C ABI wraps it function by function.
//
// Ranks    every member function is collective unless marked [local]; a failure is the same error on every rank.
// Poison   after an unstable, lost, comm or internal error in step() the engine refuses everything but looking at messages.
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "core/packing.hpp"
#include "runtime/engine_state.hpp"
#include "runtime/kept_state.hpp"

namespace talus::runtime {

/// Grains to insert, as given by one rank.
struct NewGrain {
    core::Label label;
    double position[3], velocity[3], angular_velocity[3];
    double radius;
    int material, group, colour;
};

class Engine {
public:
    Engine(const Settings& settings, std::unique_ptr<Communicator> comm);
    /// From a checkpoint; of `settings` only what does not touch physics is used.
    static std::unique_ptr<Engine> load(const std::string& path, const Settings& settings, std::unique_ptr<Communicator> comm);
    ~Engine();

    // Setting up; between steps.
    int add_material(const core::Material& m);
    void set_contact(int a, int b, const core::ContactMaterial& c);
    int add_wall(const core::WallPlane& plane);
    void set_wall_velocity(int wall, const double (&v)[3]);
    void set_laws(const core::Laws& laws);
    void set_time_step(double dt);
    void set_gravity(const double (&g)[3]);
    void set_group(int group, const core::GroupMotion& motion);
    double critical_step();
    void insert(const std::vector<NewGrain>& grains, double max_overlap);
    std::int64_t fill(core::FillPlan plan, std::int64_t count, core::Label first_label, int material, int group);
    void add_velocity(const double (&v)[3]);
    void stop_grains();
    void colour_layers(int axis, double origin, double thickness);
    std::int64_t remove_above(int axis, double level);
    std::int64_t remove_box(const double (&lo)[3], const double (&hi)[3]);
    std::int64_t remove_labels(const std::vector<core::Label>& mine);
    void mark_reference();

    /// @param done  steps finished, written on failure too  @return true when a stop was requested, even if all steps were done
    bool step(std::int64_t n_steps, std::int64_t& done);
    /// Steps to go until a time: see talus_engine_advance_to.
    std::int64_t steps_until(double time);
    /// [local, any thread, signal handlers]
    void request_stop() { stop_requested_.store(true, std::memory_order_relaxed); }

    /// A state to come back to, as often as wanted; of this engine only. [collective]
    std::unique_ptr<KeptState> keep();
    void restore(const KeptState& kept);
    void save(const std::string& path);
    void snapshot(const std::string& path);
    void start_trace(const std::string& path, std::int64_t steps);

    /// The second half kick of the last step, which waits for the next step's first, since both in one pass over the grains take half
    /// the time. Before anything else looks at velocities, or changes what moves grains. [local]
    void finish_step();
    /// Bring lists, units and forces up to date so that grains can be observed.
    void prepare();
    /// The same for contacts: ghosts move with the velocities that their owners have now, not those of the last half step. [collective]
    void prepare_contacts();
    EngineState& state() { return *state_; }
    const EngineState& state() const { return *state_; }
    std::uint64_t generation() const { return generation_; }
    bool poisoned() const { return poisoned_; }
    /// Fails if poisoned.
    void require_healthy() const;
    /// Energy of walls: work done up to now [J].
    double wall_work(int wall);

private:
    void agree_on_input();
    void check_setup();
    void fix_units();
    void derive_parameters();
    void refresh_lists();
    void expect_motion();
    void first_forces();
    void note_radii(const std::vector<NewGrain>& grains);
    void append(const std::vector<NewGrain>& grains);
    void check_labels(const std::vector<NewGrain>& grains);
    void check_overlaps(double max_overlap);
    template <class Keep>
    std::int64_t remove_unless(Keep keep);
    template <class Keep>
    std::int64_t take_out(Keep keep);
    void fold_wall_work();

    // The loop of step(): see engine_step.cpp.
    struct Verdict;
    Verdict agree_on_step(const std::vector<double>& reduced);
    std::vector<double> local_verdict();
    void collect_walls(bool count_impulse);
    void write_trace();

    std::unique_ptr<EngineState> state_;
    std::atomic<bool> stop_requested_{false};
    std::uint64_t generation_ = 1;
    bool poisoned_ = false;
    // What is out of date.
    bool lists_stale_ = true;   // grains were inserted, removed or moved from outside
    bool setup_stale_ = true;   // materials, laws, step: checks and parameters
    bool forces_stale_ = true;  // no forces yet for these grains
    bool verdict_stale_ = true; // the carried rebuild decision knows nothing of the present velocities
    bool sliced_ = false;       // subdomains follow the grains
    bool rebuild_due_ = false;
    bool kick_due_ = false; // see finish_step
    bool ghosts_behind_ = false; // they have the velocities of the last half step
    std::int64_t verdict_step_ = 0; // at which the verdict under way was taken
    std::string trace_path_;
    std::int64_t trace_left_ = 0;
};

} // namespace talus::runtime
