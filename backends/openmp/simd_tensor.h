// 3 x 3 matrices of `lanes` particles at once: products, cofactors, symmetric ones kept as rows of a buffer.
#pragma once

#include "backends/openmp/simd.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> PLIANT_INLINE Wide3<real> cross(const Wide3<real>& a, const Wide3<real>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class real> PLIANT_INLINE Wide3<real> plus(const Wide3<real>& a, const Wide3<real>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class real> PLIANT_INLINE Wide3<real> times(const Wide<real>& s, const Wide3<real>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
/// a + s b
template <class real>
PLIANT_INLINE WideMat3<real> plus(const WideMat3<real>& a, const Wide<real>& s, const WideMat3<real>& b) {
  return {plus<real>(a.x, times<real>(s, b.x)), plus<real>(a.y, times<real>(s, b.y)),
          plus<real>(a.z, times<real>(s, b.z))};
}
template <class real> PLIANT_INLINE WideMat3<real> times(const Wide<real>& s, const WideMat3<real>& a) {
  return {times<real>(s, a.x), times<real>(s, a.y), times<real>(s, a.z)};
}
/// a b
template <class real> PLIANT_INLINE WideMat3<real> product(const WideMat3<real>& a, const WideMat3<real>& b) {
  const auto row = [&](const Wide3<real>& v) {
    return Wide3<real>{v.x * b.x.x + v.y * b.y.x + v.z * b.z.x, v.x * b.x.y + v.y * b.y.y + v.z * b.z.y,
                       v.x * b.x.z + v.y * b.y.z + v.z * b.z.z};
  };
  return {row(a.x), row(a.y), row(a.z)};
}
/// Rows are cross products of the others.
template <class real> PLIANT_INLINE WideMat3<real> cofactor(const WideMat3<real>& f) {
  return {cross<real>(f.y, f.z), cross<real>(f.z, f.x), cross<real>(f.x, f.y)};
}
template <class real>
PLIANT_INLINE WideMat3<real> cofactor_change(const WideMat3<real>& f, const WideMat3<real>& df) {
  return {plus<real>(cross<real>(df.y, f.z), cross<real>(f.y, df.z)),
          plus<real>(cross<real>(df.z, f.x), cross<real>(f.z, df.x)),
          plus<real>(cross<real>(df.x, f.y), cross<real>(f.x, df.y))};
}

/// The six rows of a buffer from `row` on, in the order xx xy xz yy yz zz, of the particles from i on.
template <class real>
PLIANT_INLINE WideMat3<real> symmetric_rows_wide(const real* buffer, uint row, uint stride, uint i) {
  const real* const at = buffer + std::size_t{row} * stride + i;
  const std::size_t n = stride;
  const Wide<real> xx = load_wide(at), xy = load_wide(at + n), xz = load_wide(at + 2 * n),
                   yy = load_wide(at + 3 * n), yz = load_wide(at + 4 * n), zz = load_wide(at + 5 * n);
  return {{xx, xy, xz}, {xy, yy, yz}, {xz, yz, zz}};
}

} // namespace pliant::openmp::PLIANT_ISA
