#include "runtime/large_array.hpp"

#include <cstdint>
#include <new>

#include <malloc.h>
#include <sys/mman.h>

namespace talus::runtime {

void advise_huge_pages(const void* memory, std::size_t bytes) {
    constexpr std::uintptr_t kHuge = std::uintptr_t{2} << 20;
    const auto from = (reinterpret_cast<std::uintptr_t>(memory) + kHuge - 1) / kHuge * kHuge;
    const auto to = (reinterpret_cast<std::uintptr_t>(memory) + bytes) / kHuge * kHuge;
    if (from < to) madvise(reinterpret_cast<void*>(from), to - from, MADV_HUGEPAGE);
}

void return_free_memory() {
#if defined(__GLIBC__)
    malloc_trim(0);
#endif
}

Pages::Pages(std::size_t bytes) : bytes_(bytes) {
    if (bytes_ == 0) return;
    memory_ = mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory_ == MAP_FAILED) throw std::bad_alloc();
    advise_huge_pages(memory_, bytes_);
}

Pages::~Pages() {
    if (bytes_ > 0) munmap(memory_, bytes_);
}

} // namespace talus::runtime
