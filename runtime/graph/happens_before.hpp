// runtime/graph/happens_before.hpp: tell ThreadSanitizer which tasks TBB orders. The library is not built with it, so its own
// synchronisation is invisible; with these marks on every edge (and only there) a missing edge is still reported. Nothing in
// other builds.
#pragma once

#if defined(__SANITIZE_THREAD__)
#define TALUS_TSAN 1
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define TALUS_TSAN 1
#endif
#endif

#if defined(TALUS_TSAN)
extern "C" void __tsan_acquire(void* address);
extern "C" void __tsan_release(void* address);
/// For the body that TBB calls: it reads what it captured before it can tell what it comes after. It must do nothing else than
/// call a function that begins with Milestone::after().
#define TALUS_TASK_BODY __attribute__((no_sanitize_thread))
#else
#define TALUS_TASK_BODY
#endif

namespace talus::runtime {

/// A point that others come after: done() at its end, after() at their start.
class Milestone {
public:
    void done() {
#if defined(TALUS_TSAN)
        __tsan_release(this);
#endif
    }
    void after() {
#if defined(TALUS_TSAN)
        __tsan_acquire(this);
#endif
    }
};

} // namespace talus::runtime
