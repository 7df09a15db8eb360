// core/vec3.hpp: three components of a scalar or of a vector of lanes. Products are fused the same way on every path.
#pragma once

#include "core/simd.hpp"

namespace talus::core {

template <class V>
struct Vec3 {
    V x, y, z;
};
using Vec3d = Vec3<double>;

template <class V>
inline Vec3<V> operator+(const Vec3<V>& a, const Vec3<V>& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
template <class V>
inline Vec3<V> operator-(const Vec3<V>& a, const Vec3<V>& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
template <class V>
inline Vec3<V> operator*(const Vec3<V>& a, V s) { return {a.x * s, a.y * s, a.z * s}; }
template <class V>
inline Vec3<V> operator-(const Vec3<V>& a) { return {-a.x, -a.y, -a.z}; }

template <class V>
inline V dot(const Vec3<V>& a, const Vec3<V>& b) { return fma(a.x, b.x, fma(a.y, b.y, a.z * b.z)); }
template <class V>
inline Vec3<V> cross(const Vec3<V>& a, const Vec3<V>& b) {
    return {fnma(a.z, b.y, a.y * b.z), fnma(a.x, b.z, a.z * b.x), fnma(a.y, b.x, a.x * b.y)};
}
/// a*s + b
template <class V>
inline Vec3<V> fma(const Vec3<V>& a, V s, const Vec3<V>& b) { return {fma(a.x, s, b.x), fma(a.y, s, b.y), fma(a.z, s, b.z)}; }
/// b - a*s
template <class V>
inline Vec3<V> fnma(const Vec3<V>& a, V s, const Vec3<V>& b) { return {fnma(a.x, s, b.x), fnma(a.y, s, b.y), fnma(a.z, s, b.z)}; }

inline Vec3d make_vec3(const double (&a)[3]) { return {a[0], a[1], a[2]}; }

} // namespace talus::core
