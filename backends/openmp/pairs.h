// What the bodies of contacts between particles share.
#pragma once

#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

// From i to j where both are in one place: any direction will do that both agree on.
template <class real> PLIANT_INLINE Vec3<real> agreed_direction(uint i, uint j) {
  uint h = (smaller(i, j) * 2654435761u) ^ (larger(i, j) * 2246822519u);
  h ^= h >> 15;
  h *= 739982445u;
  h ^= h >> 12;
  const Vec3<real> d{static_cast<real>(h & 1023) - real(511.5),
                     static_cast<real>((h >> 10) & 1023) - real(511.5),
                     static_cast<real>((h >> 20) & 1023) - real(511.5)};
  return ((i < j ? real(1) : real(-1)) / norm(d)) * d;
}

} // namespace pliant::openmp::PLIANT_ISA
