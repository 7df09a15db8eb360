// apps/sandbox/process_memory.hpp: how the programs here take memory. A library may not decide this for its host.
#pragma once

#include <cstdlib>

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

} // namespace talus
