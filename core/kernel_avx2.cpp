// Four contacts at a time.
#include "core/kernel_impl.hpp"

namespace talus::core {
KernelSet select_avx2(const Laws& laws, bool ledger) { return kernel::choose<V4>(laws, ledger); }
} // namespace talus::core
