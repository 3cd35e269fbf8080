// Vectors, matrices and rotations of the CPU bodies. Everything is inlined by force, so that no copy compiled
// for a wide instruction set can be linked into code for a narrow one.
#pragma once

#include "kernels/kernel.h"

#include <cmath>

#define PLIANT_INLINE [[gnu::always_inline]] inline

namespace pliant::openmp::PLIANT_ISA {

using uint = std::uint32_t;

PLIANT_INLINE float root(float x) {
  return __builtin_sqrtf(x);
}
PLIANT_INLINE double root(double x) {
  return __builtin_sqrt(x);
}
template <class real> PLIANT_INLINE real magnitude(real x) {
  return x < 0 ? -x : x;
}
template <class real> PLIANT_INLINE real larger(real a, real b) {
  return a > b ? a : b;
}
template <class real> PLIANT_INLINE real smaller(real a, real b) {
  return a < b ? a : b;
}

template <class real> struct Vec3 { real x, y, z; };
template <class real> PLIANT_INLINE Vec3<real> xyz(const Real4<real>& v) {
  return {v.x, v.y, v.z};
}
template <class real> PLIANT_INLINE Vec3<real> operator+(Vec3<real> a, Vec3<real> b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class real> PLIANT_INLINE Vec3<real> operator-(Vec3<real> a, Vec3<real> b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class real> PLIANT_INLINE Vec3<real> operator*(real s, Vec3<real> a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class real> PLIANT_INLINE real dot(Vec3<real> a, Vec3<real> b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class real> PLIANT_INLINE Vec3<real> cross(Vec3<real> a, Vec3<real> b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class real> PLIANT_INLINE real norm(Vec3<real> a) {
  return root(dot(a, a));
}

/// Row-major: m[row][column].
template <class real> struct Mat3 { real m[3][3]; };
template <class real> PLIANT_INLINE Mat3<real> zero_matrix() {
  return {{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}};
}
template <class real> PLIANT_INLINE Vec3<real> operator*(const Mat3<real>& a, Vec3<real> v) {
  return {a.m[0][0] * v.x + a.m[0][1] * v.y + a.m[0][2] * v.z,
          a.m[1][0] * v.x + a.m[1][1] * v.y + a.m[1][2] * v.z,
          a.m[2][0] * v.x + a.m[2][1] * v.y + a.m[2][2] * v.z};
}
template <class real> PLIANT_INLINE Mat3<real> operator*(const Mat3<real>& a, const Mat3<real>& b) {
  Mat3<real> c;
  for (int r = 0; r < 3; ++r)
    for (int k = 0; k < 3; ++k)
      c.m[r][k] = a.m[r][0] * b.m[0][k] + a.m[r][1] * b.m[1][k] + a.m[r][2] * b.m[2][k];
  return c;
}
template <class real> PLIANT_INLINE Mat3<real> transposed_product(const Mat3<real>& a, const Mat3<real>& b) {
  Mat3<real> c; // a^T b
  for (int r = 0; r < 3; ++r)
    for (int k = 0; k < 3; ++k)
      c.m[r][k] = a.m[0][r] * b.m[0][k] + a.m[1][r] * b.m[1][k] + a.m[2][r] * b.m[2][k];
  return c;
}
template <class real> PLIANT_INLINE void add_outer(Mat3<real>& s, real w, Vec3<real> a, Vec3<real> b) {
  const real ax = w * a.x, ay = w * a.y, az = w * a.z;
  s.m[0][0] += ax * b.x, s.m[0][1] += ax * b.y, s.m[0][2] += ax * b.z;
  s.m[1][0] += ay * b.x, s.m[1][1] += ay * b.y, s.m[1][2] += ay * b.z;
  s.m[2][0] += az * b.x, s.m[2][1] += az * b.y, s.m[2][2] += az * b.z;
}
template <class real> PLIANT_INLINE real determinant(const Mat3<real>& a) {
  return a.m[0][0] * (a.m[1][1] * a.m[2][2] - a.m[1][2] * a.m[2][1]) -
         a.m[0][1] * (a.m[1][0] * a.m[2][2] - a.m[1][2] * a.m[2][0]) +
         a.m[0][2] * (a.m[1][0] * a.m[2][1] - a.m[1][1] * a.m[2][0]);
}
template <class real> PLIANT_INLINE real inner(const Mat3<real>& a, const Mat3<real>& b) {
  real sum = 0;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) sum += a.m[r][c] * b.m[r][c];
  return sum;
}

/// Quaternions are (x, y, z, w).
template <class real> PLIANT_INLINE Mat3<real> rotation_matrix(const Real4<real>& q) {
  const real xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z, xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z;
  const real wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
  return {{{1 - 2 * (yy + zz), 2 * (xy - wz), 2 * (xz + wy)},
           {2 * (xy + wz), 1 - 2 * (xx + zz), 2 * (yz - wx)},
           {2 * (xz - wy), 2 * (yz + wx), 1 - 2 * (xx + yy)}}};
}
template <class real>
PLIANT_INLINE Real4<real> quaternion_product(const Real4<real>& a, const Real4<real>& b) {
  return {a.w * b.x + b.w * a.x + a.y * b.z - a.z * b.y, a.w * b.y + b.w * a.y + a.z * b.x - a.x * b.z,
          a.w * b.z + b.w * a.z + a.x * b.y - a.y * b.x, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}
template <class real> PLIANT_INLINE Real4<real> normalised(const Real4<real>& q) {
  const real s = 1 / root(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  return {s * q.x, s * q.y, s * q.z, s * q.w};
}

/// One Jacobi rotation that annihilates entry (p, q) of a symmetric matrix.
template <class real> struct JacobiRotation { real c, s; };
template <class real> PLIANT_INLINE JacobiRotation<real> jacobi_rotation(real app, real aqq, real apq) {
  const real theta = (aqq - app) / (2 * apq);
  const real size = magnitude(theta);
  const real t =
      (theta < 0 ? real(-1) : real(1)) / (size + (size > real(1e10) ? size : root(theta * theta + 1)));
  const real c = 1 / root(t * t + 1);
  return {c, t * c};
}

/// The unit quaternion that maximises tr(R^T S): the eigenvector of the largest eigenvalue of Horn's (1987) 4
/// x 4 matrix, by cyclic Jacobi. Right for every S, also singular or inverted; where the answer is not unique
/// (rank one, a mirror image) a small bias chooses the one nearest to no rotation.
template <class real> [[gnu::noinline]] inline Real4<real> horn_rotation(const Mat3<real>& a) {
  const real size = root(inner(a, a));
  if (!(size > 0)) return {0, 0, 0, 1};
  Mat3<real> s = a;
  for (auto& row : s.m)
    for (real& value : row) value /= size;
  // About a hundred roundings: more than the noise of a tie, less than anybody sees.
  const real bias = sizeof(real) == 8 ? real(2e-14) : real(1e-5);
  real n[4][4] = {{s.m[0][0] + s.m[1][1] + s.m[2][2] + bias, s.m[2][1] - s.m[1][2], s.m[0][2] - s.m[2][0],
                   s.m[1][0] - s.m[0][1]},
                  {0, s.m[0][0] - s.m[1][1] - s.m[2][2], s.m[0][1] + s.m[1][0], s.m[0][2] + s.m[2][0]},
                  {0, 0, s.m[1][1] - s.m[0][0] - s.m[2][2], s.m[1][2] + s.m[2][1]},
                  {0, 0, 0, s.m[2][2] - s.m[0][0] - s.m[1][1]}};
  real v[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < r; ++c) n[r][c] = n[c][r];
  for (int sweep = 0; sweep < 10; ++sweep) {
    real off = 0;
    for (int p = 0; p < 3; ++p)
      for (int q = p + 1; q < 4; ++q) off += magnitude(n[p][q]);
    if (off < (sizeof(real) == 8 ? real(1e-17) : real(1e-9))) break;
    for (int p = 0; p < 3; ++p)
      for (int q = p + 1; q < 4; ++q) {
        if (magnitude(n[p][q]) < real(1e-20)) continue;
        const JacobiRotation<real> j = jacobi_rotation(n[p][p], n[q][q], n[p][q]);
        for (int k = 0; k < 4; ++k) {
          const real nkp = n[k][p], nkq = n[k][q];
          n[k][p] = j.c * nkp - j.s * nkq;
          n[k][q] = j.s * nkp + j.c * nkq;
        }
        for (int k = 0; k < 4; ++k) {
          const real npk = n[p][k], nqk = n[q][k], vkp = v[k][p], vkq = v[k][q];
          n[p][k] = j.c * npk - j.s * nqk;
          n[q][k] = j.s * npk + j.c * nqk;
          v[k][p] = j.c * vkp - j.s * vkq;
          v[k][q] = j.s * vkp + j.c * vkq;
        }
      }
  }
  int best = 0;
  for (int i = 1; i < 4; ++i)
    if (n[i][i] > n[best][best]) best = i;
  const real sign = v[0][best] < 0 ? real(-1) : real(1);
  return normalised<real>({sign * v[1][best], sign * v[2][best], sign * v[3][best], sign * v[0][best]});
}

/// Signed polar decomposition: the rotation (det = +1) that maximises tr(R^T S), near the start q.
/// Newton's method on the rotations. With M = R^T S and R exp[w] for R, tr changes by w . a - w . H w / 2
/// with a = axl(M - M^T), H = tr(M) I - sym(M); H is positive definite exactly at the maximum, where the sum
/// of the two smallest signed singular values is positive. Elsewhere Horn's method answers.
template <class real> PLIANT_INLINE Real4<real> polar_rotation(const Mat3<real>& s, Real4<real> q) {
  real size = 0;
  for (const auto& row : s.m)
    for (real value : row) size += magnitude(value);
  if (!(size > 0)) return q;
  const real enough =
      sizeof(real) == 8 ? real(1e-15) : real(1e-7); // squared angle after which a step is the last
  for (int iteration = 0; iteration < 8; ++iteration) {
    const Mat3<real> m = transposed_product(rotation_matrix(q), s);
    const Vec3<real> a{m.m[2][1] - m.m[1][2], m.m[0][2] - m.m[2][0], m.m[1][0] - m.m[0][1]};
    const real hxx = m.m[1][1] + m.m[2][2], hyy = m.m[0][0] + m.m[2][2], hzz = m.m[0][0] + m.m[1][1];
    const real hxy = (m.m[0][1] + m.m[1][0]) / -2, hxz = (m.m[0][2] + m.m[2][0]) / -2,
               hyz = (m.m[1][2] + m.m[2][1]) / -2;
    const real cxx = hyy * hzz - hyz * hyz, cxy = hxz * hyz - hxy * hzz, cxz = hxy * hyz - hxz * hyy;
    const real det = hxx * cxx + hxy * cxy + hxz * cxz;
    if (!(hxx > 0 && hxx * hyy - hxy * hxy > 0 && det > real(1e-5) * size * size * size)) break;
    const real cyy = hxx * hzz - hxz * hxz, cyz = hxy * hxz - hxx * hyz, czz = hxx * hyy - hxy * hxy;
    const real f = 1 / det;
    const Vec3<real> w{f * (cxx * a.x + cxy * a.y + cxz * a.z), f * (cxy * a.x + cyy * a.y + cyz * a.z),
                       f * (cxz * a.x + cyz * a.y + czz * a.z)};
    const real angle2 = dot(w, w);
    if (angle2 > 1) break;
    q = normalised(quaternion_product(q, Real4<real>{w.x / 2, w.y / 2, w.z / 2, 1}));
    if (angle2 < enough) return q;
  }
  return normalised(quaternion_product(q, horn_rotation(transposed_product(rotation_matrix(q), s))));
}

/// F with its signed singular values raised to at least `least` (Irving et al. 2004): continuous and
/// objective, and of full rank for flat, line-like and point-like shapes.
template <class real>
[[gnu::noinline]] inline Mat3<real> clamp_singular_values(const Mat3<real>& f, real least) {
  // The smallest singular value is at least det / |F|^2: nothing to do for all but the most deformed.
  if (determinant(f) > least * inner(f, f)) return f;
  const Mat3<real> r = rotation_matrix(horn_rotation(f));
  Mat3<real> p = transposed_product(r, f); // symmetric, its eigenvalues the signed singular values
  Mat3<real> v{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < i; ++j) p.m[i][j] = p.m[j][i] = (p.m[i][j] + p.m[j][i]) / 2;
  for (int sweep = 0; sweep < 8; ++sweep)
    for (int i = 0; i < 2; ++i)
      for (int j = i + 1; j < 3; ++j) {
        if (magnitude(p.m[i][j]) < real(1e-20)) continue;
        const JacobiRotation<real> g = jacobi_rotation(p.m[i][i], p.m[j][j], p.m[i][j]);
        for (int k = 0; k < 3; ++k) {
          const real a = p.m[k][i], b = p.m[k][j];
          p.m[k][i] = g.c * a - g.s * b;
          p.m[k][j] = g.s * a + g.c * b;
        }
        for (int k = 0; k < 3; ++k) {
          const real a = p.m[i][k], b = p.m[j][k], c = v.m[k][i], d = v.m[k][j];
          p.m[i][k] = g.c * a - g.s * b;
          p.m[j][k] = g.s * a + g.c * b;
          v.m[k][i] = g.c * c - g.s * d;
          v.m[k][j] = g.s * c + g.c * d;
        }
      }
  real value[3];
  bool change = false;
  for (int i = 0; i < 3; ++i) {
    change = change || p.m[i][i] < least;
    value[i] = larger(p.m[i][i], least);
  }
  if (!change) return f;
  Mat3<real> stretch = zero_matrix<real>();
  for (int i = 0; i < 3; ++i) {
    const Vec3<real> e{v.m[0][i], v.m[1][i], v.m[2][i]};
    add_outer(stretch, value[i], e, e);
  }
  return r * stretch;
}

/// Direction of a bond; where two particles coincide, that of the reference bond, which is antisymmetric.
template <class real> PLIANT_INLINE Vec3<real> bond_direction(Vec3<real> y, Vec3<real> xi) {
  const real length2 = dot(y, y), rest2 = dot(xi, xi);
  if (length2 > real(1e-14) * rest2) return (1 / root(length2)) * y;
  return rest2 > 0 ? (1 / root(rest2)) * xi : Vec3<real>{0, 0, 0};
}

} // namespace pliant::openmp::PLIANT_ISA
