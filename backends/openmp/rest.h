// Bonds of law M2 at rest, of a part of a slice.
#pragma once

#include "backends/openmp/bond_wide.h"

namespace pliant::openmp::PLIANT_ISA {

/// Weights c and lengths p over the first, of i's end (out) and of j's. With plasticity each end has its own
/// length; its modulus stays, so that c = modulus V omega / x^2 follows.
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

/// Calls work(std::bool_constant) with the kernel's option `plastic`.
template <class View, class Work> PLIANT_INLINE void with_rest(const View& k, Work work) {
  if (k.plastic)
    work(std::true_type());
  else
    work(std::false_type());
}

} // namespace pliant::openmp::PLIANT_ISA
