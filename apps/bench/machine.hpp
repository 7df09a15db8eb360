// apps/bench/machine.hpp: what the machine can do, measured when asked: the roofs that phases are compared with.
#pragma once

#include <cstddef>

namespace talus::bench {

/// McCalpin's STREAM triad, a = b + s c, on arrays of at least four times the last-level cache each, best of several passes. Bytes a
/// second by STREAM's count (24 an element: what the caches fetch in order to write does not count).
struct Triad {
    double one, all; // one thread, and as many as asked for
};
Triad triad_bandwidth(int threads);

/// The last-level cache as the system tells it [bytes], or a guess that is on the safe side.
std::size_t last_level_cache();

/// How long a unit is busy with a division or a root of four doubles [s], none waiting for another.
double divide_time();
double root_time();

} // namespace talus::bench
