// Smoothing functions of q = r / support, for one number or a wide one; see shaders/common/smoothing.glsl.
#pragma once

#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

/// (1 - q) inside, 0 beyond. `T` is a real or a Wide of them; whole numbers spread to either.
template <class T> PLIANT_INLINE T within(T q) {
  const T left = 1 - q, none{};
  return left > 0 ? left : none;
}

template <class T> PLIANT_INLINE T spline_value(T q) {
  const T a = within(q), b = within(q + q);
  return 2 * a * a * a - b * b * b;
}
template <class T> PLIANT_INLINE T spline_slope(T q) {
  const T a = within(q), inner = 18 * q - 12;
  const T outer = -6 * a * a / q; // without bound at 0, where it is not taken
  return 2 * q < 1 ? inner : outer;
}
template <class T> PLIANT_INLINE T spiky_slope(T q) {
  const T a = within(q), least = (T{} + 1) / 20;
  return -3 * a * a / (q > least ? q : least);
}
// The same from q and 1 / q, for where both are needed: one division instead of two.
template <class T> PLIANT_INLINE T spline_slope(T q, T per_q) {
  const T a = within(q), inner = 18 * q - 12, outer = -6 * a * a * per_q;
  return 2 * q < 1 ? inner : outer;
}
template <class T> PLIANT_INLINE T spiky_slope(T q, T per_q) {
  const T a = within(q), most = T{} + 20;
  return -3 * a * a * (per_q < most ? per_q : most);
}
template <class T> PLIANT_INLINE T spiky_curvature(T q) {
  return 6 * within(q);
}
template <class T> PLIANT_INLINE T viscous_laplacian(T q) {
  return within(q);
}

} // namespace pliant::openmp::PLIANT_ISA
