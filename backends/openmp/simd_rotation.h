// Rotations of `lanes` particles at once: the twin of polar_rotation() in math.h.
#pragma once

#include "backends/openmp/simd.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> struct WideMat3 { Wide<real> m[3][3]; };

template <class real> PLIANT_INLINE WideMat3<real> rotation_matrix(const Wide4<real>& q) {
  const Wide<real> x = q.x + q.x, y = q.y + q.y, z = q.z + q.z;
  const Wide<real> xx = x * q.x, yy = y * q.y, zz = z * q.z, xy = x * q.y, xz = x * q.z, yz = y * q.z;
  const Wide<real> wx = q.w * x, wy = q.w * y, wz = q.w * z;
  return {{{1 - (yy + zz), xy - wz, xz + wy},
           {xy + wz, 1 - (xx + zz), yz - wx},
           {xz - wy, yz + wx, 1 - (xx + yy)}}};
}

/// q (w / 2, 1), of unit length.
template <class real> PLIANT_INLINE Wide4<real> turned(const Wide4<real>& q, const Wide3<real>& w) {
  const Wide<real> x = w.x / 2, y = w.y / 2, z = w.z / 2;
  const Wide4<real> p{q.x + q.w * x + q.y * z - q.z * y, q.y + q.w * y + q.z * x - q.x * z,
                      q.z + q.w * z + q.x * y - q.y * x, q.w - q.x * x - q.y * y - q.z * z};
  const Wide<real> scale = 1 / root_wide<real>(p.x * p.x + p.y * p.y + p.z * p.z + p.w * p.w);
  return {scale * p.x, scale * p.y, scale * p.z, scale * p.w};
}

/// Newton's method of polar_rotation() on each lane until all have converged. The result has a bit for every
/// lane where it does not apply (flat, inverted, collapsed): polar_rotation() must answer there, from the
/// same q.
template <class real> PLIANT_INLINE uint polar_rotation(const WideMat3<real>& s, Wide4<real>& q) {
  Wide<real> size{};
  for (const auto& row : s.m)
    for (const Wide<real>& value : row) size += value < 0 ? -value : value;
  const real enough = sizeof(real) == 8 ? real(1e-15) : real(1e-7);
  const Wide<real> least = real(1e-5) * size * size * size;
  WideMask<real> live = size > 0, failed{};
  for (int iteration = 0; iteration < 8; ++iteration) {
    const WideMat3<real> r = rotation_matrix<real>(q);
    WideMat3<real> m; // R^T S
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column)
        m.m[row][column] =
            r.m[0][row] * s.m[0][column] + r.m[1][row] * s.m[1][column] + r.m[2][row] * s.m[2][column];
    const Wide3<real> a{m.m[2][1] - m.m[1][2], m.m[0][2] - m.m[2][0], m.m[1][0] - m.m[0][1]};
    const Wide<real> hxx = m.m[1][1] + m.m[2][2], hyy = m.m[0][0] + m.m[2][2], hzz = m.m[0][0] + m.m[1][1];
    const Wide<real> hxy = (m.m[0][1] + m.m[1][0]) * real(-0.5), hxz = (m.m[0][2] + m.m[2][0]) * real(-0.5),
                     hyz = (m.m[1][2] + m.m[2][1]) * real(-0.5);
    const Wide<real> cxx = hyy * hzz - hyz * hyz, cxy = hxz * hyz - hxy * hzz, cxz = hxy * hyz - hxz * hyy;
    const Wide<real> cyy = hxx * hzz - hxz * hxz, cyz = hxy * hxz - hxx * hyz, czz = hxx * hyy - hxy * hxy;
    const Wide<real> det = hxx * cxx + hxy * cxy + hxz * cxz, f = 1 / det;
    const Wide3<real> w{f * (cxx * a.x + cxy * a.y + cxz * a.z), f * (cxy * a.x + cyy * a.y + cyz * a.z),
                        f * (cxz * a.x + cyz * a.y + czz * a.z)};
    const Wide<real> angle2 = w.x * w.x + w.y * w.y + w.z * w.z;
    const WideMask<real> good = (hxx > 0) & (czz > 0) & (det > least) & (angle2 <= 1), moves = live & good;
    const Wide4<real> next = turned(q, w);
    q = {moves ? next.x : q.x, moves ? next.y : q.y, moves ? next.z : q.z, moves ? next.w : q.w};
    failed |= live & ~good;
    live = moves & (angle2 >= enough);
    if (bits<real>(live) == 0) break;
  }
  return bits<real>(failed | live);
}

} // namespace pliant::openmp::PLIANT_ISA
