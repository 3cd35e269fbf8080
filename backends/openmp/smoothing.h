// Smoothing functions of q = r / support, wide; see shaders/common/smoothing.glsl.
#pragma once

#include "backends/openmp/simd.h"

namespace pliant::openmp::PLIANT_ISA {

// The smaller and the larger of two wide values, one instruction each, of which compilers make three.
template <class T> PLIANT_INLINE T least_of(T a, T b) {
#if defined(__AVX512F__) && defined(__AVX512DQ__)
  if constexpr (sizeof(T) == 64 && sizeof(a[0]) == 4)
    return (T)_mm512_maskz_min_ps(0xFFFF, (__m512)a, (__m512)b);
#elif defined(__AVX2__)
  if constexpr (sizeof(T) == 32 && sizeof(a[0]) == 4) return (T)_mm256_min_ps((__m256)a, (__m256)b);
#endif
  return a < b ? a : b;
}
template <class T> PLIANT_INLINE T most_of(T a, T b) {
#if defined(__AVX512F__) && defined(__AVX512DQ__)
  if constexpr (sizeof(T) == 64 && sizeof(a[0]) == 4)
    return (T)_mm512_maskz_max_ps(0xFFFF, (__m512)a, (__m512)b);
#elif defined(__AVX2__)
  if constexpr (sizeof(T) == 32 && sizeof(a[0]) == 4) return (T)_mm256_max_ps((__m256)a, (__m256)b);
#endif
  return a > b ? a : b;
}

/// (1 - q) inside, 0 beyond. `T` is a Wide of reals.
template <class T> PLIANT_INLINE T within(T q) {
  return most_of<T>(1 - q, T{});
}

template <class T> PLIANT_INLINE T spline_value(T q) {
  const T a = within(q), b = most_of<T>(1 - 2 * q, T{});
  return 2 * a * a * a - b * b * b;
}
// The slopes take 1 / q too: where both are needed, they share a division. The spline's is -6 (a^2 - b^2) / q
// with a = 1 - q and b = 1 - 2 q, both 0 beyond, and a - b is q where there is b, a otherwise.
template <class T> PLIANT_INLINE T spline_slope(T q, T per_q) {
  const T a = within(q), b = most_of<T>(1 - 2 * q, T{});
  return -6 * (a + b) * least_of<T>(a * per_q, T{} + 1);
}
template <class T> PLIANT_INLINE T spiky_slope(T q, T per_q) {
  const T a = within(q);
  return -3 * a * a * least_of<T>(per_q, T{} + 20);
}
template <class T> PLIANT_INLINE T spiky_curvature(T q) {
  return 6 * within(q);
}
template <class T> PLIANT_INLINE T viscous_laplacian(T q) {
  return within(q);
}

} // namespace pliant::openmp::PLIANT_ISA
