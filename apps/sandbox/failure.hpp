// failure.hpp: how the driver ends. A Failure is always thrown on every rank with the same content (see team.hpp),
// so that main() may print it once and leave through MPI_Finalize.
#ifndef TALUS_SANDBOX_FAILURE_HPP
#define TALUS_SANDBOX_FAILURE_HPP

#include <stdexcept>
#include <string>

namespace talus::sandbox {

// Documented in --help; scripts rely on them.
enum ExitCode : int {
    kExitDone = 0,
    kExitInternal = 1, // a defect, no memory, or a machine Talus does not support
    kExitInput = 2,    // command line, configuration or bed file
    kExitUnstable = 3, // the simulation left its valid range, or a grain left the box
    kExitIo = 4,       // a file could not be read or written
    kExitMpi = 5,
    kExitStopped = 6, // on request (Ctrl-C, SIGTERM, SIGUSR1); everything has been written
};

class Failure : public std::runtime_error {
public:
    Failure(ExitCode code, const std::string& text) : std::runtime_error(text), code_(code) {}
    ExitCode code() const { return code_; }

private:
    ExitCode code_;
};

} // namespace talus::sandbox

#endif
