#include "engine.hpp"

#include <utility>

#include "signals.hpp"

namespace talus::sandbox {

namespace {

[[noreturn]] void fail(talus_status status, const std::string& doing, const char* message) {
    const std::string text = *message != '\0' ? message : talus_status_string(status);
    throw Failure(exit_code_of(status), doing + ": " + text);
}

} // namespace

ExitCode exit_code_of(talus_status status) {
    switch (status) {
    case TALUS_OK:
        return kExitDone;
    case TALUS_STOPPED:
        return kExitStopped;
    case TALUS_ERR_ARGUMENT:
        return kExitInput;
    case TALUS_ERR_UNSTABLE:
    case TALUS_ERR_LOST:
        return kExitUnstable;
    case TALUS_ERR_IO:
        return kExitIo;
    case TALUS_ERR_COMM:
        return kExitMpi;
    default:
        return kExitInternal;
    }
}

Engine::Engine(talus_engine* engine) : engine_(engine) { stop_on_signal(engine_); }

Engine::Engine(Engine&& other) noexcept : engine_(std::exchange(other.engine_, nullptr)) {}

Engine& Engine::operator=(Engine&& other) noexcept {
    std::swap(engine_, other.engine_);
    return *this;
}

Engine::~Engine() {
    if (engine_ == nullptr) return;
    stop_on_signal(nullptr);
    talus_engine_destroy(engine_);
}

void Engine::check(talus_status status, const std::string& doing) const {
    if (status < 0) fail(status, doing, talus_engine_message(engine_));
}

talus_state Engine::state() const {
    talus_state state;
    talus_state_init(&state);
    check(talus_engine_state(engine_, &state), "observing the state");
    return state;
}

void check_create(talus_status status, const std::string& doing) {
    if (status < 0) fail(status, doing, talus_message());
}

} // namespace talus::sandbox
