// Rotations of `lanes` particles at once: the twin of polar_rotation() in math.h.
#pragma once

#include "backends/openmp/simd.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> PLIANT_INLINE WideMat3<real> rotation_matrix(const Wide4<real>& q) {
  const Wide<real> x = q.x + q.x, y = q.y + q.y, z = q.z + q.z;
  const Wide<real> xx = x * q.x, yy = y * q.y, zz = z * q.z, xy = x * q.y, xz = x * q.z, yz = y * q.z;
  const Wide<real> wx = q.w * x, wy = q.w * y, wz = q.w * z;
  return {{1 - (yy + zz), xy - wz, xz + wy},
          {xy + wz, 1 - (xx + zz), yz - wx},
          {xz - wy, yz + wx, 1 - (xx + yy)}};
}

/// a^T b
template <class real>
PLIANT_INLINE WideMat3<real> transposed_product(const WideMat3<real>& a, const WideMat3<real>& b) {
  const auto row = [&](const Wide<real>& x, const Wide<real>& y, const Wide<real>& z) {
    return Wide3<real>{x * b.x.x + y * b.y.x + z * b.z.x, x * b.x.y + y * b.y.y + z * b.z.y,
                       x * b.x.z + y * b.y.z + z * b.z.z};
  };
  return {row(a.x.x, a.y.x, a.z.x), row(a.x.y, a.y.y, a.z.y), row(a.x.z, a.y.z, a.z.z)};
}

/// q (w / 2, 1), of unit length.
template <class real> PLIANT_INLINE Wide4<real> turned(const Wide4<real>& q, const Wide3<real>& w) {
  const Wide<real> x = w.x / 2, y = w.y / 2, z = w.z / 2;
  const Wide4<real> p{q.x + q.w * x + q.y * z - q.z * y, q.y + q.w * y + q.z * x - q.x * z,
                      q.z + q.w * z + q.x * y - q.y * x, q.w - q.x * x - q.y * y - q.z * z};
  const Wide<real> scale = 1 / root_wide<real>(p.x * p.x + p.y * p.y + p.z * p.z + p.w * p.w);
  return {scale * p.x, scale * p.y, scale * p.z, scale * p.w};
}

/// Twin of plane_rotation() in rotation.glsl, on each lane.
template <class real>
PLIANT_INLINE Wide4<real> plane_rotation(const WideMat3<real>& s, const Wide4<real>& before) {
  const Wide<real> along = s.x.x + s.y.y, across = s.y.x - s.x.y, none{};
  const Wide<real> size =
      magnitudes<real>(s.x.x) + magnitudes<real>(s.y.y) + magnitudes<real>(s.x.y) + magnitudes<real>(s.y.x);
  const Wide<real> length = root_wide<real>(along * along + across * across);
  const WideMask<real> turns = length > real(1e-6) * size;
  const Wide<real> c = along / length, n = across / length; // cosine and sine
  const WideMask<real> acute = c >= 0;
  const Wide<real> z = acute ? n : 1 - c, w = acute ? 1 + c : n, scale = 1 / root_wide<real>(z * z + w * w);
  return {turns ? none : before.x, turns ? none : before.y, turns ? scale * z : before.z,
          turns ? scale * w : before.w};
}

/// Newton's method of polar_rotation() on each lane until all have converged. The result has a bit for every
/// lane where it does not apply (flat, inverted, collapsed): polar_rotation() must answer there, from the
/// same q.
template <class real> PLIANT_INLINE uint polar_rotation(const WideMat3<real>& s, Wide4<real>& q) {
  const auto sum = [](const Wide3<real>& v) {
    return magnitudes<real>(v.x) + magnitudes<real>(v.y) + magnitudes<real>(v.z);
  };
  const Wide<real> size = sum(s.x) + sum(s.y) + sum(s.z), least = real(1e-5) * size * size * size;
  const real enough = sizeof(real) == 8 ? real(1e-15) : real(1e-7);
  WideMask<real> live = size > 0, failed{};
  for (int iteration = 0; iteration < 8; ++iteration) {
    const WideMat3<real> m = transposed_product(rotation_matrix<real>(q), s);
    const Wide3<real> a{m.z.y - m.y.z, m.x.z - m.z.x, m.y.x - m.x.y};
    const Wide<real> hxx = m.y.y + m.z.z, hyy = m.x.x + m.z.z, hzz = m.x.x + m.y.y;
    const Wide<real> hxy = (m.x.y + m.y.x) / -2, hxz = (m.x.z + m.z.x) / -2, hyz = (m.y.z + m.z.y) / -2;
    const Wide<real> cxx = hyy * hzz - hyz * hyz, cxy = hxz * hyz - hxy * hzz, cxz = hxy * hyz - hxz * hyy;
    const Wide<real> cyy = hxx * hzz - hxz * hxz, cyz = hxy * hxz - hxx * hyz, czz = hxx * hyy - hxy * hxy;
    const Wide<real> det = hxx * cxx + hxy * cxy + hxz * cxz, f = 1 / det;
    const Wide3<real> w{f * (cxx * a.x + cxy * a.y + cxz * a.z), f * (cxy * a.x + cyy * a.y + cyz * a.z),
                        f * (cxz * a.x + cyz * a.y + czz * a.z)};
    const Wide<real> angle2 = dot(w, w);
    const WideMask<real> good = (hxx > 0) & (czz > 0) & (det > least) & (angle2 <= 1), moves = live & good;
    const Wide4<real> next = turned(q, w);
    q = {moves ? next.x : q.x, moves ? next.y : q.y, moves ? next.z : q.z, moves ? next.w : q.w};
    failed |= live & ~good;
    live = moves & (angle2 >= enough);
    if (bits<real>(live) == 0) break;
  }
  return bits<real>(failed | live);
}

/// Lanes that Newton's method gave up: one by one, from the start that they had.
template <class real>
[[gnu::noinline]] void rotate_rest(uint failed, const WideMat3<real>& s, const Wide4<real>& before,
                                   Wide4<real>& q) {
  for (uint lane = 0; lane < lanes<real>; ++lane) {
    if (!(failed >> lane & 1)) continue;
    const Mat3<real> own{{{s.x.x[lane], s.x.y[lane], s.x.z[lane]},
                          {s.y.x[lane], s.y.y[lane], s.y.z[lane]},
                          {s.z.x[lane], s.z.y[lane], s.z.z[lane]}}};
    const Real4<real> found =
        polar_rotation(own, {before.x[lane], before.y[lane], before.z[lane], before.w[lane]});
    q.x[lane] = found.x, q.y[lane] = found.y, q.z[lane] = found.z, q.w[lane] = found.w;
  }
}

/// polar_rotation() on the first `count` lanes, from `start`.
template <class real>
PLIANT_INLINE Wide4<real> polar_rotation(const WideMat3<real>& s, const Wide4<real>& start, uint count) {
  Wide4<real> q = start;
  const uint failed = polar_rotation(s, q) & ((2u << (count - 1)) - 1);
  if (failed) rotate_rest(failed, s, start, q);
  return q;
}

} // namespace pliant::openmp::PLIANT_ISA
