#include "apps/bench/machine.hpp"

#include <algorithm>
#include <barrier>
#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include <unistd.h>

#include "core/simd.hpp"

namespace talus::bench {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point from) { return std::chrono::duration<double>(Clock::now() - from).count(); }

constexpr int kPasses = 8;
constexpr std::size_t kLeastArray = std::size_t{64} << 20; // bytes

constexpr int kOperands = 8, kRounds = 20000, kSamples = 15;

/// Of numbers with full mantissas: some units are quicker with simple ones.
template <class Operation>
double time_of(Operation operation) {
    core::V4 x[kOperands];
    for (int c = 0; c < kOperands; ++c) x[c] = core::V4{1.1, 1.3, 1.7, 1.9} + core::splat<core::V4>(0.01 * c);
    double best = 1.0;
    for (int sample = 0; sample < kSamples; ++sample) {
        const auto from = Clock::now();
        for (int round = 0; round < kRounds; ++round)
            for (core::V4& v : x) {
                asm volatile("" : "+x"(v)); // nothing is known of it, so the operation is done every time
                const core::V4 result = operation(v);
                asm volatile("" : : "x"(result));
            }
        best = std::min(best, seconds_since(from) / (static_cast<double>(kRounds) * kOperands));
    }
    return best;
}

} // namespace

std::size_t last_level_cache() {
    const long told = std::max(sysconf(_SC_LEVEL3_CACHE_SIZE), sysconf(_SC_LEVEL2_CACHE_SIZE));
    return told > 0 ? static_cast<std::size_t>(told) : kLeastArray;
}

namespace {

struct Arrays {
    std::size_t n;
    // Not touched before the threads do, so that on machines with several memories each has its own part near it.
    std::unique_ptr<double[]> a{new double[n]}, b{new double[n]}, c{new double[n]};
};

/// @param fresh  the arrays have yet to be written by these threads
double triad(const Arrays& arrays, int threads, bool fresh) {
    std::vector<double> passes;
    passes.reserve(kPasses);
    Clock::time_point from;
    bool begin = true;
    std::barrier together(threads, [&]() noexcept {
        if (begin)
            from = Clock::now();
        else
            passes.push_back(seconds_since(from));
        begin = !begin;
    });
    const auto part = [&](int t) { return arrays.n * static_cast<std::size_t>(t) / static_cast<std::size_t>(threads); };
    const auto work = [&](int t) {
        double *const a = arrays.a.get(), *const b = arrays.b.get(), *const c = arrays.c.get();
        const std::size_t lo = part(t), hi = part(t + 1);
        for (std::size_t k = lo; fresh && k < hi; ++k) {
            a[k] = 1.0;
            b[k] = 2.0;
            c[k] = 0.5;
        }
        for (int pass = 0; pass < kPasses; ++pass) {
            together.arrive_and_wait();
            for (std::size_t k = lo; k < hi; ++k) a[k] = b[k] + 3.0 * c[k];
            asm volatile("" : : "r"(a) : "memory");
            together.arrive_and_wait();
        }
    };
    {
        std::vector<std::jthread> others;
        for (int t = 1; t < threads; ++t) others.emplace_back(work, t);
        work(0);
    }
    return 3.0 * sizeof(double) * static_cast<double>(arrays.n) / *std::min_element(passes.begin(), passes.end());
}

} // namespace

Triad triad_bandwidth(int threads) {
    const Arrays arrays{std::max(4 * last_level_cache(), kLeastArray) / sizeof(double)};
    const double all = triad(arrays, threads, true);
    return {threads == 1 ? all : triad(arrays, 1, false), all};
}

double divide_time() {
    return time_of([](core::V4 v) { return core::splat<core::V4>(1.7) / v; });
}
double root_time() {
    return time_of([](core::V4 v) { return core::square_root(v); });
}

} // namespace talus::bench
