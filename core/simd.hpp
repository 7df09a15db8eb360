// core/simd.hpp: the few vector operations that the laws and kernels use, for 1, 4 and 8 doubles.
//
// Every operation is exact in IEEE-754 or correctly rounded (+ - * / sqrt fma), so a value does not depend on the width
// it was computed at: the scalar instantiation of a law is the reference of the vector ones, to the bit. GCC and clang
// vector extensions give the operators; only what they lack stands here. Laws are templates over the value type V
// (double, V4, V8) and use nothing else.
#pragma once

#include <cmath>
#include <cstdint>
#include <immintrin.h>

namespace talus::core {

using V4 = double __attribute__((vector_size(32)));
using I4 = std::int64_t __attribute__((vector_size(32)));
// For searches, whose width shows in nothing.
using F8 = float __attribute__((vector_size(32)));
using Word8 = std::int32_t __attribute__((vector_size(32)));

template <class V>
struct Lanes;
template <>
struct Lanes<double> {
    static constexpr int kWidth = 1;
    using Mask = bool;
    using Int = std::int64_t;
};
template <>
struct Lanes<V4> {
    static constexpr int kWidth = 4;
    using Mask = I4;
    using Int = I4;
};

template <class V>
inline constexpr int kLanes = Lanes<V>::kWidth;
template <class V>
using Mask = typename Lanes<V>::Mask;

template <class V>
inline V splat(double a);
template <>
inline double splat<double>(double a) { return a; }
template <>
inline V4 splat<V4>(double a) { return V4{a, a, a, a}; }

inline double square_root(double a) { return std::sqrt(a); }
inline V4 square_root(V4 a) { return (V4)_mm256_sqrt_pd((__m256d)a); }

/// a*b + c, rounded once.
inline double fma(double a, double b, double c) { return __builtin_fma(a, b, c); }
inline V4 fma(V4 a, V4 b, V4 c) { return (V4)_mm256_fmadd_pd((__m256d)a, (__m256d)b, (__m256d)c); }
/// c - a*b, rounded once.
inline double fnma(double a, double b, double c) { return __builtin_fma(-a, b, c); }
inline V4 fnma(V4 a, V4 b, V4 c) { return (V4)_mm256_fnmadd_pd((__m256d)a, (__m256d)b, (__m256d)c); }

/// b if either is not a number or both are zero, else the larger (the rule of MAXPD; likewise for the smaller).
inline double larger(double a, double b) { return a > b ? a : b; }
inline V4 larger(V4 a, V4 b) { return (V4)_mm256_max_pd((__m256d)a, (__m256d)b); }
inline double smaller(double a, double b) { return a < b ? a : b; }
inline V4 smaller(V4 a, V4 b) { return (V4)_mm256_min_pd((__m256d)a, (__m256d)b); }

inline double magnitude(double a) { return std::fabs(a); }
inline V4 magnitude(V4 a) { return (V4)_mm256_andnot_pd(_mm256_set1_pd(-0.0), (__m256d)a); }

inline double select(bool m, double a, double b) { return m ? a : b; }
inline V4 select(I4 m, V4 a, V4 b) { return (V4)_mm256_blendv_pd((__m256d)b, (__m256d)a, (__m256d)m); }

/// One bit a lane.
inline unsigned bits_of(bool m) { return m ? 1u : 0u; }
inline unsigned bits_of(I4 m) { return static_cast<unsigned>(_mm256_movemask_pd((__m256d)m)); }

/// The same of eight words; clang takes one vector for another of the same size, hence a name of its own.
inline unsigned bits_of_words(Word8 m) { return static_cast<unsigned>(_mm256_movemask_ps((__m256)m)); }
// From any address.
inline F8 load_any(const float* p) { return (F8)_mm256_loadu_ps(p); }
inline Word8 load_any(const std::uint32_t* p) { return (Word8)_mm256_loadu_si256(reinterpret_cast<const __m256i*>(p)); }

/// 1.5 * 2^52: adding it rounds a double below 2^51 to an integer held in the low mantissa bits, ties to even.
inline constexpr double kRoundMagic = 6755399441055744.0;

/// Nearest integer, ties to even, for |a| < 2^51.
template <class V>
inline V nearest(V a) {
    const V magic = splat<V>(kRoundMagic);
    return (a + magic) - magic;
}

/// Nearest integer to a * scale as int64, ties to even, for |a * scale| < 2^51.
inline std::int64_t to_integer(double a, double scale) {
    return __builtin_bit_cast(std::int64_t, fma(a, scale, kRoundMagic)) - __builtin_bit_cast(std::int64_t, kRoundMagic);
}
inline I4 to_integer(V4 a, V4 scale) {
    const V4 magic = splat<V4>(kRoundMagic);
    return (I4)fma(a, scale, magic) - (I4)magic;
}

/// Load four consecutive doubles of each of W rows, 16-byte aligned, and return the four columns.
inline void load_columns(const double* const* rows, double (&out)[4]) {
    for (int c = 0; c < 4; ++c) out[c] = rows[0][c];
}
inline void load_columns(const double* const* rows, V4 (&out)[4]) {
    // Halves of rows are put together by the loads, which leaves four shuffles of eight.
    const auto halves = [&](int a, int b, int from) { return _mm256_insertf128_pd(_mm256_castpd128_pd256(_mm_load_pd(rows[a] + from)), _mm_load_pd(rows[b] + from), 1); };
    for (int from = 0; from < 4; from += 2) {
        const __m256d even = halves(0, 2, from), odd = halves(1, 3, from);
        out[from] = (V4)_mm256_unpacklo_pd(even, odd);
        out[from + 1] = (V4)_mm256_unpackhi_pd(even, odd);
    }
}
/// The inverse: four columns to W rows of four, as doubles or as integers.
inline void to_rows(const double (&columns)[4], V4 (&rows)[1]) { rows[0] = V4{columns[0], columns[1], columns[2], columns[3]}; }
inline void to_rows(const std::int64_t (&columns)[4], I4 (&rows)[1]) { rows[0] = I4{columns[0], columns[1], columns[2], columns[3]}; }
template <class Lanes4>
inline void to_rows(const Lanes4 (&columns)[4], Lanes4 (&rows)[4]) {
    const __m256d c0 = (__m256d)columns[0], c1 = (__m256d)columns[1], c2 = (__m256d)columns[2], c3 = (__m256d)columns[3];
    const __m256d t0 = _mm256_unpacklo_pd(c0, c1), t1 = _mm256_unpackhi_pd(c0, c1);
    const __m256d t2 = _mm256_unpacklo_pd(c2, c3), t3 = _mm256_unpackhi_pd(c2, c3);
    rows[0] = (Lanes4)_mm256_permute2f128_pd(t0, t2, 0x20);
    rows[1] = (Lanes4)_mm256_permute2f128_pd(t1, t3, 0x20);
    rows[2] = (Lanes4)_mm256_permute2f128_pd(t0, t2, 0x31);
    rows[3] = (Lanes4)_mm256_permute2f128_pd(t1, t3, 0x31);
}
/// W doubles in a row, aligned to their size.
template <class V>
inline V load_lanes(const double* p);
template <>
inline double load_lanes<double>(const double* p) { return *p; }
template <>
inline V4 load_lanes<V4>(const double* p) { return (V4)_mm256_load_pd(p); }
inline void store_lanes(double* p, double v) { *p = v; }
inline void store_lanes(double* p, V4 v) { _mm256_store_pd(p, (__m256d)v); }
/// The row of a grain.
inline V4 load_row(const double* p) { return (V4)_mm256_load_pd(p); }
inline void store_row(double* p, V4 v) { _mm256_store_pd(p, (__m256d)v); }
/// sum[0..3] += row
inline void add_row(std::int64_t* sum, I4 row) {
    auto* p = reinterpret_cast<__m256i*>(sum);
    _mm256_store_si256(p, _mm256_add_epi64(_mm256_load_si256(p), (__m256i)row));
}
inline void subtract_row(std::int64_t* sum, I4 row) {
    auto* p = reinterpret_cast<__m256i*>(sum);
    _mm256_store_si256(p, _mm256_sub_epi64(_mm256_load_si256(p), (__m256i)row));
}

} // namespace talus::core
