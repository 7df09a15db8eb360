#include "signals.hpp"

#include <csignal>

#include <atomic>

namespace talus::sandbox {

namespace {

std::atomic<talus_engine*> engine_to_stop{nullptr};
std::atomic<bool> came_early{false};
static_assert(std::atomic<talus_engine*>::is_always_lock_free && std::atomic<bool>::is_always_lock_free,
              "a signal handler may only touch lock-free atomics");

extern "C" void on_signal(int number) {
    if (number != SIGUSR1) std::signal(number, SIG_DFL);
    if (talus_engine* engine = engine_to_stop.load())
        talus_engine_request_stop(engine);
    else
        came_early.store(true);
}

} // namespace

void install_signal_handlers() {
    struct sigaction action = {};
    action.sa_handler = on_signal;
    action.sa_flags = SA_RESTART; // MPI's and HDF5's system calls go on
    for (const int number : {SIGINT, SIGTERM, SIGUSR1}) sigaction(number, &action, nullptr);
    std::signal(SIGPIPE, SIG_IGN); // `talus-sandbox ... | head` must not end a run
}

void stop_on_signal(talus_engine* engine) {
    engine_to_stop.store(engine);
    if (engine != nullptr && came_early.exchange(false)) talus_engine_request_stop(engine);
}

} // namespace talus::sandbox
