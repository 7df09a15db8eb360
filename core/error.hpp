// core/error.hpp: the one exception type. A message says what is wrong, the value seen, where, and what would be right.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

#include <fmt/format.h>

namespace talus::core {

/// Numbers are those of talus.h; the ABI passes them through.
enum class ErrorKind : std::int32_t {
    argument = -1,
    state = -2,
    unstable = -3,
    lost = -4,
    io = -5,
    comm = -6,
    capacity = -7,
    unsupported = -8,
    internal = -9,
};

class Error : public std::runtime_error {
public:
    Error(ErrorKind kind, const std::string& message) : std::runtime_error(message), kind_(kind) {}
    ErrorKind kind() const { return kind_; }

private:
    ErrorKind kind_;
};

/// Throw an Error with a formatted message.
template <class... Args>
[[noreturn]] void fail(ErrorKind kind, fmt::format_string<Args...> format, Args&&... args) {
    throw Error(kind, fmt::format(format, std::forward<Args>(args)...));
}

} // namespace talus::core

/// Always on, for what only a defect of this library can break.
#define TALUS_CHECK(condition)                                                                                         \
    do {                                                                                                               \
        if (!(condition))                                                                                              \
            ::talus::core::fail(::talus::core::ErrorKind::internal, "{}:{}: broken invariant: {}", __FILE__, __LINE__, \
                                #condition);                                                                           \
    } while (false)

/// In inner loops; on in the `dev`, `asan` and `tsan` presets.
#if defined(TALUS_ASSERTIONS)
#define TALUS_ASSERT(condition) TALUS_CHECK(condition)
#else
#define TALUS_ASSERT(condition) static_cast<void>(0)
#endif
