// Walks the bonds of a particle in slices of 16 (SELL-16).
#pragma once

#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

/// Three signed 10-bit multiples of the reference grid, x lowest.
template <class real> PLIANT_INLINE Vec3<real> unpack_bond(uint word, real unit) {
  const int code = static_cast<int>(word);
  return {unit * static_cast<real>((code << 22) >> 22), unit * static_cast<real>((code << 12) >> 22),
          unit * static_cast<real>((code << 2) >> 22)};
}

/// Calls visit(j, xi, c_out, c_in) for every bond of particle `local` of a law's range; padding has no
/// weight.
template <class View, class Visit> PLIANT_INLINE void for_each_bond(const View& k, uint local, Visit visit) {
  const uint slice = k.first_slice + local / 16, lane = local % 16;
  for (uint row = k.slice_begin[slice]; row < k.slice_begin[slice + 1]; ++row) {
    const std::size_t entry = std::size_t{32} * row + lane;
    visit(k.bond[entry], unpack_bond(k.bond[entry + 16], k.unit), k.weight[entry], k.weight[entry + 16]);
  }
}

} // namespace pliant::openmp::PLIANT_ISA
