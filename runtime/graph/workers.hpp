// runtime/graph/workers.hpp: an engine's own threads, their clocks, and what they leave in a trace.
//
// TBB gives an arena no more threads than a process-wide limit, by default the processors in the affinity mask. That limit is
// raised (never lowered) to what any engine asked for: the one process-wide setting of this library. How many threads really
// worked is observed and reported.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "runtime/graph/happens_before.hpp"

namespace talus::runtime {

/// The phases of a run; one name everywhere (graph node, clock, trace, benchmark, document).
enum class Phase : int { binning, pair_build, force, integrate, halo_exchange, rebalance, observe };
inline constexpr int kPhases = 7;
const char* phase_name(Phase p);

class Workers {
public:
    explicit Workers(int threads);
    ~Workers();

    int threads() const { return threads_; }
    tbb::task_arena& arena() { return arena_; }
    /// Index of the calling worker, 0 .. threads-1.
    static int current() { return tbb::this_task_arena::current_thread_index(); }
    /// Distinct workers that ran a timed body so far.
    int observed() const;
    /// To be called from bodies of an engine's first work: wait, if the bodies are enough for all, until every worker has come. A
    /// worker that the system wakes late (more threads than processors) would otherwise find each short firing done, and sleep again.
    void muster(int bodies);

    /// Run body(i) for 0 <= i < n on the workers, timed as a phase.
    template <class Body>
    void for_each(Phase phase, int n, Body body) {
        Loop<Body> loop{*this, phase, body, {}, {}};
        loop.begin.done();
        arena_.execute([&] { tbb::parallel_for(0, n, [&loop](int i) TALUS_TASK_BODY { loop.run(i); }, tbb::simple_partitioner{}); });
        loop.end.after();
    }
    /// Run and time a body on the calling worker. `item` shows in the trace. @return seconds
    template <class Body>
    double timed(Phase phase, int item, Body body) {
        set_float_mode();
        const auto from = Clock::now();
        body();
        return note(phase, item, from, Clock::now());
    }

    struct PhaseTotal {
        double seconds = 0.0;
        std::int64_t calls = 0;
    };
    PhaseTotal total(Phase p) const;
    /// Busy seconds of all workers and phases.
    double busy() const;

    /// Record events until stop_trace(), which returns them as lines of a Chrome trace ("X" events, comma-separated).
    void start_trace();
    std::string stop_trace(int rank);

    using Clock = std::chrono::steady_clock;

private:
    template <class Body>
    struct Loop {
        Workers& workers;
        Phase phase;
        Body& body;
        Milestone begin, end;

        void run(int i) {
            begin.after();
            workers.timed(phase, i, [&] { body(i); });
            end.done();
        }
    };
    struct Event {
        Phase phase;
        int item;
        Clock::time_point from, to;
    };
    struct alignas(64) Record {
        std::array<PhaseTotal, kPhases> totals{};
        std::vector<Event> events;
        std::atomic<bool> seen{false};
    };

    /// Round to nearest, denormals kept: a host may have changed its threads' modes.
    static void set_float_mode();
    double note(Phase phase, int item, Clock::time_point from, Clock::time_point to);

    int threads_;
    tbb::task_arena arena_;
    std::vector<Record> records_;
    bool tracing_ = false;
    std::atomic<bool> mustered_{false};
};

} // namespace talus::runtime
