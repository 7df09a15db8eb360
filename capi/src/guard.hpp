// capi/src/guard.hpp: the wall between the ABI and C++. Nothing is thrown, printed or aborted through it.
#pragma once

#include <immintrin.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <new>
#include <span>
#include <string>

#include "core/error.hpp"
#include "runtime/engine.hpp"
#include "talus.h"

/// The opaque handle.
struct talus_engine {
    // Distinguishes a live handle from freed or foreign memory as far as that can be told.
    static constexpr std::uint64_t kLive = 0x54414c5553454e47ull;
    std::uint64_t live = kLive;
    std::unique_ptr<talus::runtime::Engine> engine;
    std::shared_ptr<const void> self = std::make_shared<char>(); // tells this engine from a later one at the same place
    mutable std::string message;
};

/// A state kept in memory, of one engine.
struct talus_kept {
    static constexpr std::uint64_t kLive = 0x54414c55534b4550ull;
    std::uint64_t live = kLive;
    std::weak_ptr<const void> of; // the engine's `self`
    std::unique_ptr<talus::runtime::KeptState> state;
};

namespace talus::capi {

/// The calling thread's last failure without an engine.
std::string& thread_message();

/// Round to nearest and keep denormals during a call, whatever the host has set; its own modes come back after.
class FloatModes {
public:
    FloatModes() : host_(_mm_getcsr()) { _mm_setcsr(0x1f80); }
    ~FloatModes() { _mm_setcsr(host_); }
    FloatModes(const FloatModes&) = delete;
    FloatModes& operator=(const FloatModes&) = delete;

private:
    unsigned host_;
};

/// Run a body and turn what it throws into a status and a message.
template <class Body>
talus_status guarded(std::string& message, Body body) noexcept {
    try {
        const FloatModes modes;
        message.clear();
        return body();
    } catch (const core::Error& e) {
        try {
            message = e.what();
        } catch (...) {
        }
        return static_cast<talus_status>(e.kind());
    } catch (const std::bad_alloc&) {
        try {
            message = "out of memory";
        } catch (...) {
        }
        return TALUS_ERR_CAPACITY;
    } catch (const std::exception& e) {
        try {
            message = e.what();
        } catch (...) {
        }
        return TALUS_ERR_INTERNAL;
    } catch (...) {
        return TALUS_ERR_INTERNAL;
    }
}

enum class LastStep { finished, as_it_is }; // see Engine::finish_step

/// Run body(Engine&) on a handle, whose last step is finished unless that is of no concern.
template <LastStep last = LastStep::finished, class Body>
talus_status with_engine(const talus_engine* handle, Body body) noexcept {
    if (handle == nullptr || handle->live != talus_engine::kLive)
        return guarded(thread_message(), [&]() -> talus_status { core::fail(core::ErrorKind::argument, "the engine handle is {}", handle == nullptr ? "NULL" : "not a live engine"); });
    return guarded(handle->message, [&]() -> talus_status {
        if constexpr (last == LastStep::finished) handle->engine->finish_step();
        body(*handle->engine);
        return TALUS_OK;
    });
}

template <class T>
void require(const T* pointer, const char* name) {
    if (pointer == nullptr) core::fail(core::ErrorKind::argument, "{} is NULL", name);
}
/// The same for a collective call: NULL on one rank is the error of all, before any of them waits for the others.
template <class T>
void require_on_all(runtime::Engine& e, const T* pointer, const char* name) {
    runtime::agree(*e.state().comm, [&] { require(pointer, name); });
}

/// The size that a caller's struct, or the first one of an array, says it has.
template <class Struct>
std::size_t size_of_struct(const Struct* given, const char* name) {
    require(given, name);
    const std::uint32_t size = given->struct_size;
    if (size < 2 * sizeof(std::uint32_t) || size > 65536)
        core::fail(core::ErrorKind::argument, "{}.struct_size = {}: call its _init function first", name, size);
    return size;
}

/// Read a caller's struct: what its size covers, over defaults for the rest.
/// @param defaults made by the struct's _init
template <class Struct>
Struct read_struct(const Struct* from, const char* name, Struct defaults) {
    std::memcpy(static_cast<void*>(&defaults), from, std::min(size_of_struct(from, name), sizeof(Struct)));
    defaults.struct_size = sizeof(Struct);
    return defaults;
}

/// Write to a caller's struct no more than its size covers.
template <class Struct>
void write_struct(Struct* to, const char* name, Struct value) {
    const std::size_t size = size_of_struct(to, name);
    value.struct_size = static_cast<std::uint32_t>(size);
    std::memcpy(static_cast<void*>(to), &value, std::min(size, sizeof(Struct)));
}

/// Write items to a caller's array, no more of each than an item there has.
template <class Struct>
void write_items(Struct* to, std::size_t size, std::span<const Struct> items) {
    auto* out = reinterpret_cast<std::byte*>(to);
    for (Struct item : items) {
        item.struct_size = static_cast<std::uint32_t>(size);
        std::memcpy(out, &item, std::min(size, sizeof(Struct)));
        out += size;
    }
}

/// Fill a caller's struct of this size: not a byte behind it, and struct_size says what was filled.
template <class Struct>
talus_status init_struct(Struct* out, Struct value, std::size_t size = sizeof(Struct)) noexcept {
    return guarded(thread_message(), [&]() -> talus_status {
        require(out, "the struct");
        if (size < 2 * sizeof(std::uint32_t)) core::fail(core::ErrorKind::argument, "struct_size = {}: smaller than any struct of Talus", size);
        const std::size_t known = std::min(size, sizeof(Struct));
        value.struct_size = static_cast<std::uint32_t>(known);
        std::memcpy(static_cast<void*>(out), &value, known);
        return TALUS_OK;
    });
}

core::Laws to_laws(const talus_laws& l);

/// Read the corners of a box, which must not be empty.
inline void read_box(const double* lo, const double* hi, double (&from)[3], double (&to)[3]) {
    require(lo, "lo");
    require(hi, "hi");
    for (int a = 0; a < 3; ++a) {
        from[a] = lo[a];
        to[a] = hi[a];
        if (!(from[a] < to[a])) core::fail(core::ErrorKind::argument, "the box is empty along {}: {} to {}", "xyz"[a], from[a], to[a]);
    }
}

} // namespace talus::capi
