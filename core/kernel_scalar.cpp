// The reference: one contact at a time.
#include "core/kernel_impl.hpp"

namespace talus::core {
KernelSet select_scalar(const Laws& laws, bool ledger) { return kernel::choose<double>(laws, ledger); }
} // namespace talus::core
