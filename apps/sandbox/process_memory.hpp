// apps/sandbox/process_memory.hpp: how the programs here take memory, and how much they hold. A library may not decide this for its
// host.
#pragma once

#include <cstdlib>
#include <fstream>
#include <string>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace talus {

/// Blocks from 128 KiB on come straight from the system and go back to it. glibc starts so, but raises the limit with the largest block it
/// was ever given back, and from then on lists of tiles leave holes in one heap.
/// Before the first large block; a setting of the environment (MALLOC_MMAP_THRESHOLD_) goes before.
inline void keep_large_blocks_apart() {
#ifdef __GLIBC__
    constexpr int kLarge = 128 * 1024;
    if (std::getenv("MALLOC_MMAP_THRESHOLD_") == nullptr) mallopt(M_MMAP_THRESHOLD, kLarge);
#endif
}

/// Hand free memory back to the system, as far as the allocator can.
inline void give_memory_back() {
#ifdef __GLIBC__
    malloc_trim(0);
#endif
}

/// A figure of /proc/self/status, which are in kB [bytes]; zero where the system does not tell.
inline double status_bytes(const char* name) {
    std::ifstream status("/proc/self/status");
    for (std::string word; status >> word;)
        if (word == std::string(name) + ":") {
            double kilobytes = 0.0;
            status >> kilobytes;
            return 1024.0 * kilobytes;
        }
    return 0.0;
}

/// Resident bytes of this process: now, and at most since forget_peak().
inline double resident_bytes() { return status_bytes("VmRSS"); }
inline double peak_bytes() { return status_bytes("VmHWM"); }
inline void forget_peak() { std::ofstream("/proc/self/clear_refs") << "5"; }

} // namespace talus
