#include "runtime/graph/workers.hpp"

#include <mutex>
#include <thread>

#include <fmt/format.h>
#include <immintrin.h>
#include <tbb/global_control.h>

namespace talus::runtime {

namespace {

/// Raise the process-wide limit of TBB to at least `threads`.
void raise_thread_limit(int threads) {
    static std::mutex guard;
    static std::unique_ptr<tbb::global_control> control;
    static std::size_t limit = 0;
    const std::lock_guard lock(guard);
    const auto wanted = static_cast<std::size_t>(threads);
    if (limit == 0) limit = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
    if (wanted <= limit) return;
    limit = wanted;
    control.reset();
    control = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism, limit);
}

constexpr unsigned kDefaultMxcsr = 0x1f80; // all exceptions masked, round to nearest, no flush to zero

} // namespace

const char* phase_name(Phase p) {
    constexpr const char* kNames[kPhases] = {"binning", "pair_build", "force", "integrate", "halo_exchange", "rebalance", "observe"};
    return kNames[static_cast<int>(p)];
}

Workers::Workers(int threads) : threads_(threads), records_(static_cast<std::size_t>(threads) + 1) {
    raise_thread_limit(threads);
    arena_.initialize(threads);
}
Workers::~Workers() = default;

void Workers::set_float_mode() {
    if ((_mm_getcsr() & ~0x3fu) != kDefaultMxcsr) _mm_setcsr(kDefaultMxcsr);
}

double Workers::note(Phase phase, int item, Clock::time_point from, Clock::time_point to) {
    // Bodies outside the arena (the calling thread between graphs) have no index: the last record is theirs.
    const int index = current();
    Record& r = records_[index >= 0 && index < threads_ ? index : threads_];
    auto& total = r.totals[static_cast<int>(phase)];
    const double seconds = std::chrono::duration<double>(to - from).count();
    total.seconds += seconds;
    ++total.calls;
    r.seen.store(true, std::memory_order_relaxed);
    if (tracing_) r.events.push_back({phase, item, from, to});
    return seconds;
}

int Workers::observed() const {
    int n = 0;
    for (int k = 0; k < threads_; ++k) n += records_[k].seen.load(std::memory_order_relaxed) ? 1 : 0;
    return n;
}

void Workers::muster(int bodies) {
    if (bodies < threads_ || mustered_.load(std::memory_order_relaxed)) return;
    constexpr auto kPatience = std::chrono::seconds(2);
    records_[current()].seen.store(true, std::memory_order_relaxed);
    const auto deadline = Clock::now() + kPatience;
    while (observed() < threads_ && Clock::now() < deadline) std::this_thread::yield();
    mustered_.store(true, std::memory_order_relaxed);
}

Workers::PhaseTotal Workers::total(Phase p) const {
    PhaseTotal sum;
    for (const Record& r : records_) {
        sum.seconds += r.totals[static_cast<int>(p)].seconds;
        sum.calls += r.totals[static_cast<int>(p)].calls;
    }
    return sum;
}

double Workers::busy() const {
    double s = 0.0;
    for (int p = 0; p < kPhases; ++p) s += total(static_cast<Phase>(p)).seconds;
    return s;
}

void Workers::start_trace() {
    for (Record& r : records_) r.events.clear();
    tracing_ = true;
}

std::string Workers::stop_trace(int rank) {
    tracing_ = false;
    std::string out = fmt::format(R"({{"name":"process_name","ph":"M","pid":{0},"args":{{"name":"rank {0}"}}}})", rank);
    for (std::size_t w = 0; w < records_.size(); ++w) {
        const std::string name = static_cast<int>(w) < threads_ ? fmt::format("worker {}", w) : std::string("caller");
        out += fmt::format(",\n{{\"name\":\"thread_name\",\"ph\":\"M\",\"pid\":{},\"tid\":{},\"args\":{{\"name\":\"{}\"}}}}", rank, w, name);
        for (const Event& e : records_[w].events) {
            const double from = std::chrono::duration<double, std::micro>(e.from.time_since_epoch()).count();
            const double length = std::chrono::duration<double, std::micro>(e.to - e.from).count();
            out += fmt::format(",\n{{\"name\":\"{}\",\"ph\":\"X\",\"pid\":{},\"tid\":{},\"ts\":{:.3f},\"dur\":{:.3f},\"args\":{{\"item\":{}}}}}", phase_name(e.phase), rank, w, from, length, e.item);
        }
        records_[w].events.clear();
    }
    return out;
}

} // namespace talus::runtime
