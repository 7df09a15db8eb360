// engine.hpp: owns a talus_engine and turns its statuses into Failures. The engine agrees on a status over all ranks,
// so a Failure thrown here is thrown everywhere; TALUS_ERR_COMM is the exception, and is marked as kExitMpi.
#ifndef TALUS_SANDBOX_ENGINE_HPP
#define TALUS_SANDBOX_ENGINE_HPP

#include <talus_mpi.h>

#include <string>

#include "failure.hpp"

namespace talus::sandbox {

ExitCode exit_code_of(talus_status status);

class Engine {
public:
    Engine() = default;
    explicit Engine(talus_engine* engine);
    Engine(Engine&& other) noexcept;
    Engine& operator=(Engine&& other) noexcept;
    ~Engine();

    talus_engine* get() const { return engine_; }

    // Throws unless `status` is 0 or positive. `doing` opens the message: what was being done, to which input.
    void check(talus_status status, const std::string& doing) const;

    talus_state state() const;

private:
    talus_engine* engine_ = nullptr;
};

// For calls without an engine: failed creates and loads.
void check_create(talus_status status, const std::string& doing);

} // namespace talus::sandbox

#endif
