// Collective agreement on errors: no failure leaves one rank waiting for another.
#include <bit>

#include "runtime/engine_state.hpp"

namespace talus::runtime {

void agree_on(Communicator& comm, std::int32_t severity, const std::string& message) {
    const std::int64_t worst = comm.max(static_cast<std::int64_t>(severity));
    if (worst == 0) return;
    const std::int64_t lowest = -comm.max(severity == worst ? -static_cast<std::int64_t>(comm.rank()) : -static_cast<std::int64_t>(comm.size()));
    throw core::Error(static_cast<core::ErrorKind>(-worst), comm.broadcast(message, static_cast<int>(lowest)));
}

void agree(Communicator& comm, const std::function<void()>& stage) {
    std::int32_t severity = 0;
    std::string message;
    try {
        stage();
    } catch (const core::Error& e) {
        severity = -static_cast<std::int32_t>(e.kind());
        message = e.what();
    } catch (const std::bad_alloc&) {
        severity = -static_cast<std::int32_t>(core::ErrorKind::capacity);
        message = fmt::format("rank {}: out of memory", comm.rank());
    } catch (const std::exception& e) {
        severity = -static_cast<std::int32_t>(core::ErrorKind::internal);
        message = e.what();
    }
    agree_on(comm, severity, message);
}

void require_same(Communicator& comm, const char* what, std::span<const double> values) {
    if (comm.size() == 1) return;
    std::vector<double> v;
    for (const double x : values) {
        // Halves of the bits: numbers, whatever the value is, and zero differs from minus zero.
        const auto bits = std::bit_cast<std::uint64_t>(x);
        for (const auto half : {static_cast<double>(bits >> 32), static_cast<double>(bits & 0xffffffffu)}) {
            v.push_back(half);
            v.push_back(-half);
        }
    }
    comm.max(v);
    for (std::size_t k = 0; k < v.size(); k += 2)
        if (v[k] != -v[k + 1]) throw core::Error(core::ErrorKind::argument, fmt::format("{}: the values differ between ranks; every rank must give the same, to the bit", what));
}

} // namespace talus::runtime
