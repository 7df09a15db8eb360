// runtime/large_array.hpp: memory of arrays with an item or more a grain.
#pragma once

#include <cstddef>
#include <vector>

namespace talus::runtime {

/// Ask for huge pages under memory that has not been touched yet. Advice: what the system does not do costs speed only.
void advise_huge_pages(const void* memory, std::size_t bytes);

/// A vector with room for n items, and a little more if it grows, instead of up to twice as many as push_back would make.
template <class T>
void reallocate(std::vector<T>& v, std::size_t n) {
    std::vector<T> other;
    other.reserve(v.empty() ? n : n + n / 16);
    advise_huge_pages(other.data(), other.capacity() * sizeof(T));
    other.assign(v.begin(), v.end());
    v.swap(other);
}
/// Room for n items.
template <class T>
void make_large_room(std::vector<T>& v, std::size_t n) {
    if (v.capacity() < n) reallocate(v, n);
}
/// Give back room that is far too much.
template <class T>
void trim(std::vector<T>& v) {
    if (v.capacity() > v.size() + v.size() / 4 + 4096) reallocate(v, v.size());
}

/// Give pages that the allocator holds for nobody back to the system, where it can.
void return_free_memory();

/// Scratch straight from the system, and back to it: an allocator might keep it. Not initialised.
class Pages {
public:
    /// @throws std::bad_alloc
    explicit Pages(std::size_t bytes);
    ~Pages();
    Pages(const Pages&) = delete;
    Pages& operator=(const Pages&) = delete;
    template <class T>
    T* as() const {
        return static_cast<T*>(memory_);
    }

private:
    std::size_t bytes_;
    void* memory_ = nullptr;
};

} // namespace talus::runtime
