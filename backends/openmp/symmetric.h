// Symmetric matrices as six rows of a buffer, their eigenvalues, and a little algebra of 3 x 3 matrices.
#pragma once

#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

/// The six rows of `buffer` from `row` on, in the order xx xy xz yy yz zz, of particle i.
template <class real>
PLIANT_INLINE Mat3<real> symmetric_rows(const real* buffer, uint row, uint stride, uint i) {
  const real* const at = buffer + std::size_t{row} * stride + i;
  const std::size_t n = stride;
  return {{{at[0], at[n], at[2 * n]}, {at[n], at[3 * n], at[4 * n]}, {at[2 * n], at[4 * n], at[5 * n]}}};
}

/// Eigenvalues of a symmetric matrix by cyclic Jacobi, in no order.
template <class real> [[gnu::noinline]] inline Vec3<real> symmetric_values(Mat3<real> a) {
  for (int sweep = 0; sweep < 8; ++sweep)
    for (int p = 0; p < 2; ++p)
      for (int q = p + 1; q < 3; ++q) {
        if (magnitude(a.m[p][q]) < real(1e-20)) continue;
        const JacobiRotation<real> g = jacobi_rotation(a.m[p][p], a.m[q][q], a.m[p][q]);
        for (int k = 0; k < 3; ++k) {
          const real x = a.m[k][p], y = a.m[k][q];
          a.m[k][p] = g.c * x - g.s * y;
          a.m[k][q] = g.s * x + g.c * y;
        }
        for (int k = 0; k < 3; ++k) {
          const real x = a.m[p][k], y = a.m[q][k];
          a.m[p][k] = g.c * x - g.s * y;
          a.m[q][k] = g.s * x + g.c * y;
        }
      }
  return {a.m[0][0], a.m[1][1], a.m[2][2]};
}

/// s A.
template <class real> PLIANT_INLINE Mat3<real> scaled(real s, Mat3<real> a) {
  for (auto& row : a.m)
    for (real& value : row) value *= s;
  return a;
}
template <class real> PLIANT_INLINE Mat3<real> operator-(Mat3<real> a, const Mat3<real>& b) {
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) a.m[r][c] -= b.m[r][c];
  return a;
}
template <class real>
PLIANT_INLINE void store_rows(Real4<real>* to, const Mat3<real>& a, real x, real y, real z) {
  to[0] = {a.m[0][0], a.m[0][1], a.m[0][2], x};
  to[1] = {a.m[1][0], a.m[1][1], a.m[1][2], y};
  to[2] = {a.m[2][0], a.m[2][1], a.m[2][2], z};
}

} // namespace pliant::openmp::PLIANT_ISA
