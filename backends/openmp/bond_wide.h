// Bonds of a part of a slice, 16 bytes or more at once.
#pragma once

#include "backends/openmp/simd.h"

namespace pliant::openmp::PLIANT_ISA {

/// A bond's lengths and its direction; where two particles coincide, that of the reference bond.
template <class real> struct WideBond {
  Wide<real> x, size, per_x;
  Wide3<real> n;
};
/// `xi` in grid units, `unit` as grid_unit() gives it. Padding has no length.
template <class real>
PLIANT_INLINE WideBond<real> wide_bond(const Wide3<real>& y, const Wide3<real>& xi, real unit) {
  WideBond<real> b;
  const Wide<real> none{}, length2 = dot(y, y);
  b.x = unit * root_wide<real>(dot(xi, xi));
  b.size = root_wide<real>(length2);
  b.per_x = b.x > 0 ? 1 / b.x : none;
  const auto distinct = length2 > real(1e-14) * b.x * b.x;
  const Wide<real> now = distinct ? 1 / b.size : none, rest = distinct ? none : unit * b.per_x;
  b.n = {now * y.x + rest * xi.x, now * y.y + rest * xi.y, now * y.z + rest * xi.z};
  return b;
}

} // namespace pliant::openmp::PLIANT_ISA
