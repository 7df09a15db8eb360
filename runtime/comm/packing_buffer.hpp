// runtime/comm/packing_buffer.hpp: plain values to bytes and back, in order.
#pragma once

#include <cstring>
#include <type_traits>

#include "core/error.hpp"
#include "runtime/comm/communicator.hpp"

namespace talus::runtime {

class Packer {
public:
    template <class T>
    void put(const T& v) {
        put_many(&v, 1);
    }
    template <class T>
    void put_many(const T* v, std::size_t n) {
        static_assert(std::is_trivially_copyable_v<T>);
        const auto* from = reinterpret_cast<const std::byte*>(v);
        bytes_.insert(bytes_.end(), from, from + n * sizeof(T));
    }
    /// Count, then items.
    template <class T>
    void put_all(const std::vector<T>& v) {
        put(static_cast<std::uint64_t>(v.size()));
        put_many(v.data(), v.size());
    }
    Bytes take() { return std::move(bytes_); }
    bool empty() const { return bytes_.empty(); }

private:
    Bytes bytes_;
};

class Unpacker {
public:
    explicit Unpacker(const Bytes& bytes) : bytes_(bytes) {}

    template <class T>
    T get() {
        T v;
        get_many(&v, 1);
        return v;
    }
    template <class T>
    void get_many(T* out, std::size_t n) {
        static_assert(std::is_trivially_copyable_v<T>);
        TALUS_CHECK(at_ + n * sizeof(T) <= bytes_.size());
        if (n > 0) std::memcpy(static_cast<void*>(out), bytes_.data() + at_, n * sizeof(T));
        at_ += n * sizeof(T);
    }
    template <class T>
    std::vector<T> get_all() {
        std::vector<T> v(get<std::uint64_t>());
        get_many(v.data(), v.size());
        return v;
    }
    bool done() const { return at_ == bytes_.size(); }

private:
    const Bytes& bytes_;
    std::size_t at_ = 0;
};

} // namespace talus::runtime
