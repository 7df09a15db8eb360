// apps/bench/counted.hpp: a number that counts what is done with it. Laws and kernels are templates over their value type, so what
// they compute is counted by running them, not by reading them.
#pragma once

#include "core/simd.hpp"

namespace talus::bench {

struct Operations {
    double add = 0, multiply = 0, fused = 0, divide = 0, root = 0;
    double other = 0; // comparisons, the larger and smaller of two, choices, signs: no floating-point operation by custom

    /// A fused multiply-add is two; a division and a root are one each.
    double flops() const { return add + multiply + 2.0 * fused + divide + root; }
    Operations& operator+=(const Operations& b) {
        add += b.add;
        multiply += b.multiply;
        fused += b.fused;
        divide += b.divide;
        root += b.root;
        other += b.other;
        return *this;
    }
    Operations scaled(double factor) const { return {add * factor, multiply * factor, fused * factor, divide * factor, root * factor, other * factor}; }
};

/// Of the calling thread.
inline thread_local Operations operations;

/// What a body does.
template <class Body>
Operations count(Body body) {
    operations = {};
    body();
    return operations;
}

struct Counted {
    double v;
};
struct CountedMask {
    bool b;
};

inline Counted tell(double& counter, double value) {
    counter += 1.0;
    return {value};
}
inline CountedMask tell(bool value) {
    operations.other += 1.0;
    return {value};
}

inline Counted operator+(Counted a, Counted b) { return tell(operations.add, a.v + b.v); }
inline Counted operator-(Counted a, Counted b) { return tell(operations.add, a.v - b.v); }
inline Counted operator*(Counted a, Counted b) { return tell(operations.multiply, a.v * b.v); }
inline Counted operator/(Counted a, Counted b) { return tell(operations.divide, a.v / b.v); }
inline Counted operator-(Counted a) { return tell(operations.other, -a.v); }
inline CountedMask operator<(Counted a, Counted b) { return tell(a.v < b.v); }
inline CountedMask operator<=(Counted a, Counted b) { return tell(a.v <= b.v); }
inline CountedMask operator>(Counted a, Counted b) { return tell(a.v > b.v); }
inline CountedMask operator>=(Counted a, Counted b) { return tell(a.v >= b.v); }
inline Counted square_root(Counted a) { return tell(operations.root, core::square_root(a.v)); }
inline Counted fma(Counted a, Counted b, Counted c) { return tell(operations.fused, core::fma(a.v, b.v, c.v)); }
inline Counted fnma(Counted a, Counted b, Counted c) { return tell(operations.fused, core::fnma(a.v, b.v, c.v)); }
inline Counted larger(Counted a, Counted b) { return tell(operations.other, core::larger(a.v, b.v)); }
inline Counted smaller(Counted a, Counted b) { return tell(operations.other, core::smaller(a.v, b.v)); }
inline Counted magnitude(Counted a) { return tell(operations.other, core::magnitude(a.v)); }
inline CountedMask operator&(CountedMask a, CountedMask b) { return tell(a.b && b.b); }
inline CountedMask operator|(CountedMask a, CountedMask b) { return tell(a.b || b.b); }
inline Counted select(CountedMask m, Counted a, Counted b) { return tell(operations.other, m.b ? a.v : b.v); }
inline unsigned bits_of(CountedMask m) { return core::bits_of(m.b); }

// From and to memory and integers.
inline std::int64_t to_integer(Counted a, Counted scale) {
    operations.fused += 1.0; // scaled and rounded
    return core::to_integer(a.v, scale.v);
}
inline void store_lanes(double* p, Counted a) { *p = a.v; }
inline void load_columns(const double* const* rows, Counted (&out)[4]) {
    for (int c = 0; c < 4; ++c) out[c] = {rows[0][c]};
}
inline void to_rows(const Counted (&columns)[4], core::V4 (&rows)[1]) { rows[0] = core::V4{columns[0].v, columns[1].v, columns[2].v, columns[3].v}; }
inline double lane(Counted a, int) { return a.v; }

} // namespace talus::bench

namespace talus::core {

template <>
struct Lanes<bench::Counted> {
    static constexpr int kWidth = 1;
    using Mask = bench::CountedMask;
    using Int = std::int64_t;
};
template <>
inline bench::Counted splat<bench::Counted>(double a) { return {a}; }
template <>
inline bench::Counted load_lanes<bench::Counted>(const double* p) { return {*p}; }

} // namespace talus::core
