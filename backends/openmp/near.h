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
/// The same for coordinates less than a period and a half away from the centre.
template <class real> PLIANT_INLINE Wide<real> nearest_images(Wide<real> at, real centre, real period) {
  if (!(period > 0)) return at;
  const Wide<real> none{}, all = spread(period), away = at - centre;
  return at - (2 * away > period ? all : none) + (2 * away < -period ? all : none);
}

/// Lanes chosen by bits, packed together: store() writes them, and up to `lanes` elements of no meaning.
template <class real> class Chosen {
public:
  PLIANT_INLINE explicit Chosen(uint chosen) : chosen_(chosen) {}
  PLIANT_INLINE uint count() const { return static_cast<uint>(__builtin_popcount(chosen_)); }

  template <class T, class Vector> PLIANT_INLINE void store(T* to, Vector value) const {
#if defined(__AVX512F__) && defined(__AVX512DQ__)
    if constexpr (sizeof(Vector) == 64 && sizeof(T) == 4) {
      __m512i all;
      __builtin_memcpy(&all, &value, sizeof all);
      const __m512i packed = _mm512_maskz_compress_epi32(static_cast<__mmask16>(chosen_), all);
      __builtin_memcpy(to, &packed, sizeof packed);
      return;
    }
#elif defined(__AVX2__)
    if constexpr (sizeof(Vector) == 32 && sizeof(T) == 4) {
      __m256i all;
      __builtin_memcpy(&all, &value, sizeof all);
      const __m256i order = _mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i*)(orders.of[chosen_])));
      const __m256i packed = _mm256_permutevar8x32_epi32(all, order);
      __builtin_memcpy(to, &packed, sizeof packed);
      return;
    }
#endif
    uint at = 0;
    for (uint left = chosen_; left; left &= left - 1) to[at++] = value[__builtin_ctz(left)];
  }

private:
  /// For each choice of eight lanes, these lanes first.
  struct Orders {
    alignas(64) unsigned char of[256][8] = {};
    constexpr Orders() {
      for (uint chosen = 0; chosen < 256; ++chosen)
        for (uint lane = 0, at = 0; lane < 8; ++lane)
          if (chosen >> lane & 1) of[chosen][at++] = static_cast<unsigned char>(lane);
    }
  };
  static constexpr Orders orders{};
  uint chosen_;
};

/// A difference of coordinates that are less than a period and a half apart, as short as images make it.
template <class real> PLIANT_INLINE Wide<real> shortest(Wide<real> d, real period) {
  const Wide<real> none{}, all = spread(period);
  d -= 2 * d > period ? all : none;
  d += 2 * d < -period ? all : none;
  return d;
}

/// As gather() of simd.h; loads that go straight into the upper half of a register save an instruction.
template <class real> PLIANT_INLINE Wide4<real> gather_near(const Real4<real>* base, const uint* index) {
#if defined(__AVX2__) && !(defined(__AVX512F__) && defined(__AVX512DQ__))
  if constexpr (sizeof(real) == 4) {
    const auto row = [&](uint lane) {
      const __m256 low = _mm256_castps128_ps256(_mm_load_ps(&base[index[lane]].x));
      return (Wide<real>)_mm256_insertf128_ps(low, _mm_load_ps(&base[index[lane + 4]].x), 1);
    };
    return transposed<real>({row(0), row(1), row(2), row(3)});
  }
#endif
  return gather(base, index);
}

/// What leads from neighbours to `place`, of these places.
template <class View, class real>
PLIANT_INLINE Wide3<real> from_near(const View& k, const Real4<real>* places, const Wide4<real>& place,
                                    const uint* neighbours) {
  const Wide4<real> other = gather_near(places, neighbours);
  return {shortest<real>(place.x - other.x, k.period_x), shortest<real>(place.y - other.y, k.period_y),
          shortest<real>(place.z - other.z, k.period_z)};
}

/// Calls visit(neighbours, d, own) for every row of the list of a part of a slice: places of the neighbours,
/// what leads from them to the own places (.w: that of `places`), and where the neighbour is the own place,
/// for which nothing may be added.
template <class View, class real, class Visit>
PLIANT_INLINE void for_each_near(const View& k, const Real4<real>* places, const Part<real>& part,
                                 const Wide4<real>& place, Visit visit) {
  const uint slice = part.first / 16;
  const bool repeats = k.period_x > 0 || k.period_y > 0 || k.period_z > 0;
  const WideInt<real> self = load_words<real>(part.index);
  const uint* row = k.near + std::size_t{16} * k.rows * slice + part.first % 16;
  const uint* const end = row + 16 * k.near_count[slice];
  const auto difference = [&](Wide4<real>& d) {
    const Wide4<real> other = gather_near(places, row);
    d = {place.x - other.x, place.y - other.y, place.z - other.z, other.w};
  };
  const auto same = [&]() { return __builtin_convertvector(load_words<real>(row) == self, WideMask<real>); };
  if (!repeats) {
    for (; row != end; row += 16) {
      __builtin_prefetch(row + std::size_t{16} * k.rows); // the next slice, on a page of its own
      Wide4<real> d;
      difference(d);
      visit(row, d, same());
    }
    return;
  }
  for (; row != end; row += 16) {
    Wide4<real> d;
    difference(d);
    if (k.period_x > 0) d.x = shortest<real>(d.x, k.period_x);
    if (k.period_y > 0) d.y = shortest<real>(d.y, k.period_y);
    if (k.period_z > 0) d.z = shortest<real>(d.z, k.period_z);
    visit(row, d, same());
  }
}
/// The same over fluid_place, whose w is the mass.
template <class View, class real, class Visit>
PLIANT_INLINE void for_each_near(const View& k, const Part<real>& part, const Wide4<real>& place,
                                 Visit visit) {
  for_each_near(k, k.fluid_place, part, place, visit);
}

/// What w of a place counts with: ghosts have the negative of it.
template <class real> PLIANT_INLINE Wide<real> counting_mass(Wide<real> w) {
  const WideMask<real> sign = (WideMask<real>)(-Wide<real>{});
  return (Wide<real>)((WideMask<real>)w & ~sign);
}

} // namespace pliant::openmp::PLIANT_ISA
