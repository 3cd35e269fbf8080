// Bonds of law M2 at rest.
#pragma once

#include "backends/openmp/slice.h"

namespace pliant::openmp::PLIANT_ISA {

/// Weights c and lengths p over the first, of i's end (out) and of j's. With plasticity each end has its own
/// length; its modulus stays, so that c = modulus V omega / x^2 follows.
template <class real> struct RestBond { real c_out, c_in, p_out, p_in; };

/// Calls visit(j, xi, RestBond) for every bond of particle `local` of a law's range; padding has no weight.
template <bool plastic, class View, class Visit>
PLIANT_INLINE void for_each_bond_at_rest(const View& k, uint local, Visit visit) {
  using real = typename View::real;
  const uint slice = k.first_slice + local / 16, lane = local % 16;
  for (uint row = k.slice_begin[slice]; row < k.slice_begin[slice + 1]; ++row) {
    const std::size_t entry = std::size_t{32} * row + lane;
    RestBond<real> at_rest{k.weight[entry], k.weight[entry + 16], 1, 1};
    if constexpr (plastic) {
      at_rest.p_out = k.rest[entry], at_rest.p_in = k.rest[entry + 16];
      at_rest.c_out /= at_rest.p_out * at_rest.p_out;
      at_rest.c_in /= at_rest.p_in * at_rest.p_in;
    }
    visit(k.bond[entry], unpack_bond(k.bond[entry + 16], k.unit), at_rest);
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
