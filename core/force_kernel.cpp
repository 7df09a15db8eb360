#include "core/force_kernel.hpp"

#include <limits>

#include "core/error.hpp"
#include "core/kernel_build.hpp"
#include "core/law/choose.hpp"

namespace talus::core {

void TileGrains::gather(const Particle* particles, const std::vector<LocalIndex>& index_of) {
    const std::size_t n = index_of.size();
    if (centre.size() < n) {
        centre.resize(n);
        motion.resize(n);
        spin.resize(n);
    }
    material = n > 0 ? material_of(particles[index_of[0]]) : 0;
    V4 lo = splat<V4>(std::numeric_limits<double>::infinity()), hi = -lo;
    for (std::size_t k = 0; k < n; ++k) {
        const Particle& p = particles[index_of[k]];
        const V4 at = load_row(p.position);
        lo = smaller(at, lo);
        hi = larger(at, hi);
        store_row(centre[k].v, at);
        store_row(motion[k].v, load_row(p.velocity));
        store_row(spin[k].v, load_row(p.angular_velocity));
        if (material_of(p) != material) material = -1;
    }
    for (int a = 0; a < 3; ++a) extent[a] = n > 0 ? hi[a] - lo[a] : 0.0;
}

void no_such_law(const char* kind, int number) { fail(ErrorKind::internal, "{} law {} does not exist", kind, number); }

KernelSet select_scalar(const Laws& laws, bool ledger);
KernelSet select_avx2(const Laws& laws, bool ledger);
KernelSet select_avx512(const Laws& laws, bool ledger);

bool has_width(KernelWidth width) {
    if (width != KernelWidth::eight) return true;
#ifdef TALUS_EIGHT_LANES
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
#else
    return false;
#endif
}

KernelSet select_kernels(const Laws& laws, bool ledger, KernelWidth width) {
    if (width == KernelWidth::automatic) width = has_width(KernelWidth::eight) ? KernelWidth::eight : KernelWidth::four;
    if (width == KernelWidth::scalar) return select_scalar(laws, ledger);
    if (width == KernelWidth::four) return select_avx2(laws, ledger);
    if (!has_width(width)) fail(ErrorKind::unsupported, "kernels of eight lanes need a processor with AVX-512 (F, DQ, VL) and an optimised build by GCC");
#ifdef TALUS_EIGHT_LANES
    return select_avx512(laws, ledger);
#else
    fail(ErrorKind::internal, "kernels of eight lanes are not in this build");
#endif
}

const char* laws_fault(const Laws& l) {
    if (l.rolling == RollingLaw::spring && l.rolling_radius == RollingRadius::own)
        return "rolling_radius OWN goes with the constant torque (type A) only: the spring (type C) keeps one moment for both grains; use EFFECTIVE";
    if (l.normal == NormalLaw::linear && !(l.stiffness_n > 0.0))
        return "the linear law needs stiffness_n > 0 [N/m]";
    if (l.normal == NormalLaw::linear && !(l.stiffness_t >= 0.0)) return "stiffness_t must be >= 0 [N/m]; 0 takes 2/7 of stiffness_n";
    if (l.rolling == RollingLaw::constant && !(l.rolling_rate > 0.0)) return "rolling_rate must be > 0 [rad/s]";
    if (l.rolling == RollingLaw::spring && !(l.rolling_damping >= 0.0)) return "rolling_damping must be >= 0 [1]";
    return nullptr;
}

} // namespace talus::core
