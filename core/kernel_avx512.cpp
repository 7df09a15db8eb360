// Eight contacts at a time. The one source that is compiled for AVX-512: nothing in it but the kernels themselves may become code
// that others call, or a machine without AVX-512 would be given it. They are inlined whole, and a test looks at the symbols.
#include "core/kernel_impl.hpp"

#ifdef TALUS_EIGHT_LANES
#include "core/simd_avx512.hpp"

namespace talus::core {
KernelSet select_avx512(const Laws& laws, bool ledger) { return kernel::choose<V8>(laws, ledger); }
} // namespace talus::core
#endif
