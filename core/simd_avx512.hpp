// core/simd_avx512.hpp: eight doubles, for the one source that is compiled for AVX-512 (kernel_avx512.cpp). The operations of simd.hpp,
// with the same results to the bit.
#pragma once

#include "core/simd.hpp"

namespace talus::core {

struct V8 {
    __m512d v;
    double operator[](int l) const { return v[l]; }
};
struct M8 {
    __mmask8 k;
};
struct I8 {
    __m512i v;
};
template <>
struct Lanes<V8> {
    static constexpr int kWidth = 8;
    using Mask = M8;
    using Int = I8;
};
template <>
inline V8 splat<V8>(double a) { return {_mm512_set1_pd(a)}; }

template <>
inline V8 load_lanes<V8>(const double* p) { return {_mm512_load_pd(p)}; }
inline void store_lanes(double* p, V8 v) { _mm512_store_pd(p, v.v); }

inline V8 operator+(V8 a, V8 b) { return {_mm512_add_pd(a.v, b.v)}; }
inline V8 operator-(V8 a, V8 b) { return {_mm512_sub_pd(a.v, b.v)}; }
inline V8 operator*(V8 a, V8 b) { return {_mm512_mul_pd(a.v, b.v)}; }
inline V8 operator/(V8 a, V8 b) { return {_mm512_div_pd(a.v, b.v)}; }
inline V8 operator-(V8 a) { return {_mm512_xor_pd(a.v, _mm512_set1_pd(-0.0))}; }

inline M8 operator<(V8 a, V8 b) { return {_mm512_cmp_pd_mask(a.v, b.v, _CMP_LT_OQ)}; }
inline M8 operator<=(V8 a, V8 b) { return {_mm512_cmp_pd_mask(a.v, b.v, _CMP_LE_OQ)}; }
inline M8 operator>(V8 a, V8 b) { return b < a; }
inline M8 operator>=(V8 a, V8 b) { return b <= a; }
inline M8 operator&(M8 a, M8 b) { return {static_cast<__mmask8>(a.k & b.k)}; }
inline M8 operator|(M8 a, M8 b) { return {static_cast<__mmask8>(a.k | b.k)}; }

inline V8 square_root(V8 a) { return {_mm512_sqrt_pd(a.v)}; }
inline V8 fma(V8 a, V8 b, V8 c) { return {_mm512_fmadd_pd(a.v, b.v, c.v)}; }
inline V8 fnma(V8 a, V8 b, V8 c) { return {_mm512_fnmadd_pd(a.v, b.v, c.v)}; }
inline V8 larger(V8 a, V8 b) { return {_mm512_max_pd(a.v, b.v)}; }
inline V8 smaller(V8 a, V8 b) { return {_mm512_min_pd(a.v, b.v)}; }
inline V8 magnitude(V8 a) { return {_mm512_andnot_pd(_mm512_set1_pd(-0.0), a.v)}; }
inline V8 select(M8 m, V8 a, V8 b) { return {_mm512_mask_blend_pd(m.k, b.v, a.v)}; }
inline unsigned bits_of(M8 m) { return m.k; }
inline I8 to_integer(V8 a, V8 scale) {
    const V8 magic = splat<V8>(kRoundMagic);
    return {_mm512_sub_epi64(_mm512_castpd_si512(fma(a, scale, magic).v), _mm512_castpd_si512(magic.v))};
}

/// Elements 0, 1 of each 256-bit half of two vectors, or 2, 3 of each: a's, then b's.
inline __m512d join_low(__m512d a, __m512d b) { return _mm512_permutex2var_pd(a, _mm512_set_epi64(13, 12, 5, 4, 9, 8, 1, 0), b); }
inline __m512d join_high(__m512d a, __m512d b) { return _mm512_permutex2var_pd(a, _mm512_set_epi64(15, 14, 7, 6, 11, 10, 3, 2), b); }

inline void load_columns(const double* const* rows, V8 (&out)[4]) {
    const auto two = [&](int l) { return _mm512_insertf64x4(_mm512_castpd256_pd512(_mm256_load_pd(rows[l])), _mm256_load_pd(rows[l + 4]), 1); };
    const __m512d r0 = two(0), r1 = two(1), r2 = two(2), r3 = two(3);
    const __m512d t0 = _mm512_unpacklo_pd(r0, r1), t1 = _mm512_unpackhi_pd(r0, r1);
    const __m512d t2 = _mm512_unpacklo_pd(r2, r3), t3 = _mm512_unpackhi_pd(r2, r3);
    out[0] = {join_low(t0, t2)};
    out[1] = {join_low(t1, t3)};
    out[2] = {join_high(t0, t2)};
    out[3] = {join_high(t1, t3)};
}
/// Rows l and l + 4 in the halves of rows[l], l < 4.
inline void to_row_pairs(__m512d c0, __m512d c1, __m512d c2, __m512d c3, __m512d (&pairs)[4]) {
    const __m512d t0 = _mm512_unpacklo_pd(c0, c1), t1 = _mm512_unpackhi_pd(c0, c1);
    const __m512d t2 = _mm512_unpacklo_pd(c2, c3), t3 = _mm512_unpackhi_pd(c2, c3);
    pairs[0] = join_low(t0, t2);
    pairs[1] = join_low(t1, t3);
    pairs[2] = join_high(t0, t2);
    pairs[3] = join_high(t1, t3);
}
inline void to_rows(const V8 (&columns)[4], V4 (&rows)[8]) {
    __m512d pairs[4];
    to_row_pairs(columns[0].v, columns[1].v, columns[2].v, columns[3].v, pairs);
    for (int l = 0; l < 4; ++l) {
        rows[l] = (V4)_mm512_castpd512_pd256(pairs[l]);
        rows[l + 4] = (V4)_mm512_extractf64x4_pd(pairs[l], 1);
    }
}
inline void to_rows(const I8 (&columns)[4], I4 (&rows)[8]) {
    V8 as_double[4];
    V4 out[8];
    for (int c = 0; c < 4; ++c) as_double[c] = {_mm512_castsi512_pd(columns[c].v)};
    to_rows(as_double, out);
    for (int l = 0; l < 8; ++l) rows[l] = (I4)out[l];
}

} // namespace talus::core
