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

/// RestBond of rest.h, of a part.
template <class real> struct WideRestBond { Wide<real> c_out, c_in, p_out, p_in; };

/// for_each_bond_of_part() with the lengths at rest, visit(neighbours, xi, WideRestBond).
template <bool plastic, class View, class Visit>
PLIANT_INLINE void for_each_bond_at_rest_of_part(const View& k, uint local, Visit visit) {
  using real = typename View::real;
  const uint slice = k.first_slice + local / 16, lane = local % 16;
  for (std::size_t row = k.slice_begin[slice], end = k.slice_begin[slice + 1]; row < end; ++row) {
    const std::size_t entry = 32 * row + lane;
    const Wide<real> one = Wide<real>{} + 1;
    WideRestBond<real> at_rest{load_wide(k.weight + entry), load_wide(k.weight + entry + 16), one, one};
    if constexpr (plastic) {
      at_rest.p_out = load_wide(k.rest + entry), at_rest.p_in = load_wide(k.rest + entry + 16);
      at_rest.c_out /= at_rest.p_out * at_rest.p_out;
      at_rest.c_in /= at_rest.p_in * at_rest.p_in;
    }
    visit(k.bond + entry, unpack_bonds<real>(load_words<real>(k.bond + entry + 16)), at_rest);
  }
}

} // namespace pliant::openmp::PLIANT_ISA
