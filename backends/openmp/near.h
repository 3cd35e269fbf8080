// Lists of neighbours of fluids, SELL-16, and distances where a domain repeats.
#pragma once

#include "backends/openmp/simd.h"

namespace pliant::openmp::PLIANT_ISA {

/// The whole number nearest to x, for |x| < 1e9.
template <class real> PLIANT_INLINE real nearest_whole(real x) {
  const real bounded = larger(smaller(x, real(1e9)), real(-1e9));
  return static_cast<real>(static_cast<int>(bounded + (bounded < 0 ? real(-0.5) : real(0.5))));
}
/// The image of a coordinate that is nearest to `centre`; period 0: nothing repeats.
template <class real> PLIANT_INLINE real nearest_image(real at, real centre, real period) {
  return period > 0 ? at - period * nearest_whole((at - centre) / period) : at;
}
/// A difference of coordinates that are less than a period and a half apart, as short as images make it.
template <class real> PLIANT_INLINE Wide<real> shortest(Wide<real> d, real period) {
  const Wide<real> none{}, all = spread(period);
  d -= 2 * d > period ? all : none;
  d += 2 * d < -period ? all : none;
  return d;
}

/// Calls visit(neighbours, d, own) for every row of the list of a part of a slice: places of the neighbours,
/// what leads from them to the own places (.w: their mass), and where the neighbour is the own place, for
/// which nothing may be added.
template <class View, class Visit>
PLIANT_INLINE void for_each_near(const View& k, const Part<typename View::real>& part,
                                 const Wide4<typename View::real>& place, Visit visit) {
  using real = typename View::real;
  const uint slice = part.first / 16;
  const bool repeats = k.period_x > 0 || k.period_y > 0 || k.period_z > 0;
  const WideInt<real> self = load_words<real>(part.index);
  const uint* row = k.near + std::size_t{16} * k.rows * slice + part.first % 16;
  for (uint r = 0; r < k.near_count[slice]; ++r, row += 16) {
    const Wide4<real> other = gather(k.fluid_place, row);
    Wide4<real> d{place.x - other.x, place.y - other.y, place.z - other.z, other.w};
    if (repeats) {
      if (k.period_x > 0) d.x = shortest<real>(d.x, k.period_x);
      if (k.period_y > 0) d.y = shortest<real>(d.y, k.period_y);
      if (k.period_z > 0) d.z = shortest<real>(d.z, k.period_z);
    }
    visit(row, d, __builtin_convertvector(load_words<real>(row) == self, WideMask<real>));
  }
}

} // namespace pliant::openmp::PLIANT_ISA
