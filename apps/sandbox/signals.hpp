// signals.hpp: SIGINT, SIGTERM and SIGUSR1 ask the run to stop after its current step, with everything written. A
// second SIGINT or SIGTERM ends the process at once. (mpirun passes SIGUSR1 on as it is; after SIGINT and SIGTERM it
// gives the ranks a short time only.)
#ifndef TALUS_SANDBOX_SIGNALS_HPP
#define TALUS_SANDBOX_SIGNALS_HPP

#include <talus.h>

namespace talus::sandbox {

void install_signal_handlers();

// The engine that a signal stops; nullptr before it dies. A signal that came earlier is passed on now.
void stop_on_signal(talus_engine* engine);

} // namespace talus::sandbox

#endif
