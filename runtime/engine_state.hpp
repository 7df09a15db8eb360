// runtime/engine_state.hpp: all that one rank of an engine is; the phases work on it.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "core/candidate_pairs.hpp"
#include "core/contact_probe.hpp"
#include "core/error.hpp"
#include "core/integrate.hpp"
#include "core/balance.hpp"
#include "core/skin_choice.hpp"
#include "core/slice_grid.hpp"
#include "runtime/comm/communicator.hpp"
#include "runtime/comm/halo.hpp"
#include "runtime/graph/step_graph.hpp"
#include "runtime/graph/workers.hpp"
#include "runtime/model.hpp"
#include "runtime/subdomain.hpp"

namespace talus::runtime {

/// The first error of a rank, kept until all ranks have agreed on it.
class ErrorSlot {
public:
    void set(core::ErrorKind kind, const std::string& message) {
        const std::lock_guard lock(guard_);
        if (kind_ == kNone) {
            kind_ = static_cast<std::int32_t>(kind);
            message_ = message;
        }
    }
    /// 0 or the number of the kind, positive.
    std::int32_t severity() const {
        const std::lock_guard lock(guard_);
        return -kind_;
    }
    const std::string& message() const { return message_; }

private:
    static constexpr std::int32_t kNone = 0;
    mutable std::mutex guard_;
    std::int32_t kind_ = kNone;
    std::string message_;
};

struct Counters {
    std::int64_t rebuilds = 0, rebalances = 0, migrations = 0;
    double imbalance = 1.0;       // max/mean of busy time over the last list's life
};

/// The lists in use, or those last in use, as this rank saw them; and what is agreed about their skin.
struct ListWatch {
    // Of this rank.
    std::int64_t built_step = 0;
    double rebuild_seconds = 0.0;   // that they took, times threads
    double force_before = 0.0;      // s of the force phase at their start
    double force_seconds = 0.0;     // busy in their life
    std::int64_t contacts = 0, candidates = 0;
    bool counted = false;           // they are gone, and the two lines above are theirs
    bool disturbed = false;         // what comes is not what was: the host has changed grains, or how they move
    // The same on every rank.
    std::int64_t steps = -1;        // of their life at the last verdict on them, -1 before the first
    double skin_use = 0.0;          // SkinUse::foreseen over all ranks
    double apart = 0.0;             // m, foreseen relative displacement of any two grains
    core::SkinModel known;          // as of the last lists that were agreed on
};

/// What the work of a rank takes, and what is agreed about sharing it out.
struct LoadWatch {
    // Of this rank.
    double busy_before = 0.0;   // step_seconds when the lists were built
    double grain_seconds = 0.0; // that a grain takes of a step, smoothed over lists; 0: not known
    double move_seconds = 0.0;  // that this rank's part of the last move of cuts took; 0: told already
    double rebuild_seconds = 0.0;
    // The same on every rank.
    core::BalanceLedger ledger;
    double mean = 0.0;          // s that a rank works in a step, as of the last lists; 0: not known
    std::int64_t rebuilds = 0;  // since cuts were last looked at, by a policy that counts them

    /// Seconds of all workers in the phases of steps; rebuilds and observation come when they are asked for.
    static double step_seconds(const Workers& w) {
        double sum = 0.0;
        for (const Phase p : {Phase::force, Phase::integrate, Phase::halo_exchange}) sum += w.total(p).seconds;
        return sum;
    }
    /// Seconds that each of a rank's threads has worked in steps since the lists were built.
    double busy_since(const Workers& w) const { return (step_seconds(w) - busy_before) / w.threads(); }
};

struct EngineState {
    EngineState(const Settings& settings, std::unique_ptr<Communicator> communicator)
        : comm(std::move(communicator)), halo(*comm), workers(settings.threads),
          candidate_scratch(static_cast<std::size_t>(settings.threads)), inherit_scratch(static_cast<std::size_t>(settings.threads)), tile_grains(static_cast<std::size_t>(settings.threads)) {
        model.settings = settings;
    }

    std::unique_ptr<Communicator> comm;
    Model model;
    Subdomain sub;
    core::SliceGrid slices;
    Halo halo; // before the workers and the graph, which use it
    Workers workers;
    ErrorSlot errors;
    Counters counters;
    ListWatch watch;
    LoadWatch load;

    // One firing of the step graph: what its nodes read.
    core::ForceContext force;
    core::IntegrateContext integrate;
    core::KernelSet kernels{};
    bool with_forces = false;
    bool halo_under_way = false; // a message a neighbour is on its way to this rank
    std::unique_ptr<StepGraph> graph;

    // One a worker.
    std::vector<core::CandidateScratch> candidate_scratch;
    std::vector<core::InheritScratch> inherit_scratch;
    std::vector<core::TileGrains> tile_grains;

    bool parallel() const { return comm->size() > 1; }
};

/// Run a stage that may fail on some ranks only; every rank then throws the same error. [collective]
void agree(Communicator& comm, const std::function<void()>& stage);
/// Throw the worst error of any rank (largest severity, then lowest rank) on all of them; returns if there is none. [collective]
void agree_on(Communicator& comm, std::int32_t severity, const std::string& message);
/// Fail on all ranks if numbers that must be the same everywhere are not, to the bit. [collective]
void require_same(Communicator& comm, const char* what, std::span<const double> values);

} // namespace talus::runtime
