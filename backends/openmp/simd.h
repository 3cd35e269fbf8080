// Wide values: one lane a particle, as many lanes as a register of the instruction set holds. A slice of 16
// particles is worked off in parts of that many lanes, so that the sums of a part stay in registers.
//
//   x86-64-v4   16 float   8 double      x86-64-v3   8 float   4 double      elsewhere   4 float   4 double
//
// Vectors of the compiler (GCC, Clang) carry the arithmetic; intrinsics stand only where these have no word.
#pragma once

#include "backends/openmp/slice.h"

#include <utility>
#if defined(__SSE2__)
#include <immintrin.h>
#endif
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi" // wide values cross no call: everything here is inlined by force
#endif

namespace pliant::openmp::PLIANT_ISA {

#if defined(__AVX512F__) && defined(__AVX512DQ__)
inline constexpr uint register_bytes = 64;
#elif defined(__AVX2__)
inline constexpr uint register_bytes = 32;
#else
inline constexpr uint register_bytes = 16;
#endif

template <class real, uint bytes> struct VectorOf { typedef real Type __attribute__((vector_size(bytes))); };

template <class real>
inline constexpr uint lanes = register_bytes / sizeof(real) < 4 ? 4 : register_bytes / sizeof(real);
template <class real> using Wide = typename VectorOf<real, lanes<real> * sizeof(real)>::Type;
/// Of 32 bits each, for `lanes<real>` lanes.
template <class real> using WideInt = typename VectorOf<std::int32_t, lanes<real> * 4>::Type;
/// All bits of a lane set or none: what a comparison gives.
template <class real> using WideMask = decltype(Wide<real>{} < Wide<real>{});
/// Four reals: one Real4.
template <class real> using Quad = typename VectorOf<real, 4 * sizeof(real)>::Type;

template <class real> PLIANT_INLINE Wide<real> spread(real value) {
  return value - Wide<real>{};
}
template <class real> PLIANT_INLINE Wide<real> load_wide(const real* from) {
  Wide<real> value;
  __builtin_memcpy(&value, from, sizeof value);
  return value;
}
template <class real> PLIANT_INLINE WideInt<real> load_words(const uint* from) {
  WideInt<real> value;
  __builtin_memcpy(&value, from, sizeof value);
  return value;
}
template <class real> PLIANT_INLINE Quad<real> load_quad(const Real4<real>& from) {
  Quad<real> value;
  __builtin_memcpy(&value, &from, sizeof value);
  return value;
}
template <class real> PLIANT_INLINE void store_quad(Real4<real>& to, Quad<real> value) {
  __builtin_memcpy(&to, &value, sizeof value);
}

/// One bit a lane, lane 0 lowest.
template <class real> PLIANT_INLINE uint bits(WideMask<real> mask) {
#if defined(__AVX512F__) && defined(__AVX512DQ__)
  if constexpr (sizeof(mask) == 64) {
    __m512i all;
    __builtin_memcpy(&all, &mask, sizeof all);
    return sizeof(real) == 4 ? static_cast<uint>(_mm512_movepi32_mask(all))
                             : static_cast<uint>(_mm512_movepi64_mask(all));
  }
#elif defined(__AVX2__)
  if constexpr (sizeof(mask) == 32 && sizeof(real) == 4) {
    __m256 all;
    __builtin_memcpy(&all, &mask, sizeof all);
    return static_cast<uint>(_mm256_movemask_ps(all));
  }
  if constexpr (sizeof(mask) == 32 && sizeof(real) == 8) {
    __m256d all;
    __builtin_memcpy(&all, &mask, sizeof all);
    return static_cast<uint>(_mm256_movemask_pd(all));
  }
#endif
  uint result = 0;
  for (uint lane = 0; lane < lanes<real>; ++lane) result |= mask[lane] ? 1u << lane : 0u;
  return result;
}

template <class real> PLIANT_INLINE Wide<real> root_wide(Wide<real> x) {
#if defined(__AVX512F__) && defined(__AVX512DQ__)
  if constexpr (sizeof(real) == 4)
    return (Wide<real>)_mm512_maskz_sqrt_ps(0xFFFF, (__m512)x);
  else
    return (Wide<real>)_mm512_maskz_sqrt_pd(0xFF, (__m512d)x);
#elif defined(__AVX2__)
  if constexpr (sizeof(real) == 4)
    return (Wide<real>)_mm256_sqrt_ps((__m256)x);
  else
    return (Wide<real>)_mm256_sqrt_pd((__m256d)x);
#else
  for (uint lane = 0; lane < lanes<real>; ++lane) x[lane] = root(x[lane]);
  return x;
#endif
}

template <class real> PLIANT_INLINE Wide<real> magnitudes(Wide<real> x) {
  return x < 0 ? -x : x;
}

// Pieces side by side, and lanes by constant position: both become one or two instructions.
template <class Out, class In, int... at>
PLIANT_INLINE Out arrange(In a, In b, std::integer_sequence<int, at...>) {
  return __builtin_shufflevector(a, b, at...);
}
template <class Out, class In> PLIANT_INLINE Out joined(In low, In high) {
  return arrange<Out>(low, high, std::make_integer_sequence<int, sizeof(Out) / sizeof(low[0])>());
}
template <uint first, class real> PLIANT_INLINE Quad<real> quad_of(Wide<real> value) {
  if constexpr (lanes<real> == 4)
    return value;
  else
    return __builtin_shufflevector(value, value, first, first + 1, first + 2, first + 3);
}

/// Puts lane `pattern[k]` of each group of four at k; 4 to 7 stand for the second operand.
template <int p0, int p1, int p2, int p3, class real> struct InFours {
  static constexpr int count = static_cast<int>(lanes<real>);
  static constexpr int at(int k) {
    const int pattern[4] = {p0, p1, p2, p3}, from = pattern[k % 4], group = k / 4 * 4;
    return from < 4 ? group + from : count + group + from - 4;
  }
  template <int... k>
  PLIANT_INLINE static Wide<real> apply(Wide<real> a, Wide<real> b, std::integer_sequence<int, k...>) {
    return __builtin_shufflevector(a, b, at(k)...);
  }
};
template <class real, int p0, int p1, int p2, int p3>
PLIANT_INLINE Wide<real> in_fours(Wide<real> a, Wide<real> b) {
  return InFours<p0, p1, p2, p3, real>::apply(
      a, b, std::make_integer_sequence<int, InFours<p0, p1, p2, p3, real>::count>());
}

/// Four wide values; as x, y, z, w of `lanes` particles, or as `lanes` / 4 groups of four rows.
template <class real> struct Wide4 { Wide<real> x, y, z, w; };
template <class real> struct Wide3 { Wide<real> x, y, z; };
/// By rows. Names rather than indices: an array would live in memory.
template <class real> struct WideMat3 { Wide3<real> x, y, z; };
template <class real>
PLIANT_INLINE void add_outer(WideMat3<real>& s, const Wide3<real>& a, const Wide3<real>& b) {
  s.x.x += a.x * b.x, s.x.y += a.x * b.y, s.x.z += a.x * b.z;
  s.y.x += a.y * b.x, s.y.y += a.y * b.y, s.y.z += a.y * b.z;
  s.z.x += a.z * b.x, s.z.y += a.z * b.y, s.z.z += a.z * b.z;
}
template <class real> PLIANT_INLINE Wide<real> dot(const Wide3<real>& a, const Wide3<real>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class real> PLIANT_INLINE Wide3<real> operator*(const WideMat3<real>& a, const Wide3<real>& v) {
  return {dot(a.x, v), dot(a.y, v), dot(a.z, v)};
}
template <class real> PLIANT_INLINE Wide<real> inner(const WideMat3<real>& a, const WideMat3<real>& b) {
  return dot(a.x, b.x) + dot(a.y, b.y) + dot(a.z, b.z);
}

/// Transposes each 4 x 4 group: its own inverse.
template <class real> PLIANT_INLINE Wide4<real> transposed(const Wide4<real>& r) {
  if constexpr (sizeof(real) == 4) { // a group is 128 bits
    const auto a = in_fours<real, 0, 4, 1, 5>(r.x, r.y), b = in_fours<real, 2, 6, 3, 7>(r.x, r.y);
    const auto c = in_fours<real, 0, 4, 1, 5>(r.z, r.w), d = in_fours<real, 2, 6, 3, 7>(r.z, r.w);
    return {in_fours<real, 0, 1, 4, 5>(a, c), in_fours<real, 2, 3, 6, 7>(a, c),
            in_fours<real, 0, 1, 4, 5>(b, d), in_fours<real, 2, 3, 6, 7>(b, d)};
  } else { // a group is two halves of 128 bits
    const auto a = in_fours<real, 0, 4, 2, 6>(r.x, r.y), b = in_fours<real, 1, 5, 3, 7>(r.x, r.y);
    const auto c = in_fours<real, 0, 4, 2, 6>(r.z, r.w), d = in_fours<real, 1, 5, 3, 7>(r.z, r.w);
    return {in_fours<real, 0, 1, 4, 5>(a, c), in_fours<real, 0, 1, 4, 5>(b, d),
            in_fours<real, 2, 3, 6, 7>(a, c), in_fours<real, 2, 3, 6, 7>(b, d)};
  }
}

/// Row k of each group: the quads of particles index[k], index[4 + k], ...
template <uint row, uint stride, class real>
PLIANT_INLINE Wide<real> gather_row(const Real4<real>* base, const uint* index) {
  const auto quad = [&](uint lane) { return load_quad(base[std::size_t{stride} * index[lane]]); };
  if constexpr (lanes<real> == 4) {
    return quad(row);
  } else if constexpr (lanes<real> == 8) {
    return joined<Wide<real>>(quad(row), quad(4 + row));
  } else {
    using Half = typename VectorOf<real, 8 * sizeof(real)>::Type;
    return joined<Wide<real>>(joined<Half>(quad(row), quad(4 + row)),
                              joined<Half>(quad(8 + row), quad(12 + row)));
  }
}

/// base[stride * index[lane]] of each lane.
template <uint stride = 1, class real>
PLIANT_INLINE Wide4<real> gather(const Real4<real>* base, const uint* index) {
  return transposed<real>({gather_row<0, stride>(base, index), gather_row<1, stride>(base, index),
                           gather_row<2, stride>(base, index), gather_row<3, stride>(base, index)});
}

/// base[stride * i] for the first `count` lanes, whose particles follow one another.
template <uint stride = 1, class real>
PLIANT_INLINE void store(Real4<real>* base, uint count, const Wide4<real>& value) {
  const Wide4<real> rows = transposed(value);
  const auto put = [&](uint lane, Quad<real> quad) {
    if (lane < count) store_quad(base[std::size_t{stride} * lane], quad);
  };
  const auto group = [&]<uint first>(std::integral_constant<uint, first>) {
    put(first, quad_of<first, real>(rows.x));
    put(first + 1, quad_of<first, real>(rows.y));
    put(first + 2, quad_of<first, real>(rows.z));
    put(first + 3, quad_of<first, real>(rows.w));
  };
  group(std::integral_constant<uint, 0>());
  if constexpr (lanes<real> >= 8) group(std::integral_constant<uint, 4>());
  if constexpr (lanes<real> == 16) {
    group(std::integral_constant<uint, 8>());
    group(std::integral_constant<uint, 12>());
  }
}

/// The first `count` lanes.
template <class real> PLIANT_INLINE void store_reals(real* to, uint count, const Wide<real>& value) {
  if (count == lanes<real>) {
    __builtin_memcpy(to, &value, sizeof value);
  } else {
    for (uint lane = 0; lane < count; ++lane) to[lane] = value[lane];
  }
}

/// A part of a slice: `count` particles from `first` on; lanes past them repeat the last.
template <class real> struct Part {
  uint first, count;
  uint index[lanes<real>];
};
template <class real> PLIANT_INLINE Part<real> make_part(uint first, uint left) {
  Part<real> part;
  part.first = first;
  part.count = smaller(left, lanes<real>);
  for (uint lane = 0; lane < lanes<real>; ++lane) part.index[lane] = first + smaller(lane, part.count - 1);
  return part;
}

/// Calls visit(part, local) for the parts of slice s of a law's range; local: of the part's first particle.
template <class View, class Visit> PLIANT_INLINE void for_each_part(const View& k, uint s, Visit visit) {
  using real = typename View::real;
  for (uint local = 16 * s; local < smaller(16 * s + 16, k.threads); local += lanes<real>)
    visit(make_part<real>(k.first + local, k.threads - local), local);
}
PLIANT_INLINE uint slice_count(uint particles) {
  return (particles + 15) / 16;
}

/// A bond's reference vector in units of unit / 2^22: each code stays at the top of its word, where its sign
/// is. Exact in float; sums are multiplied by grid_unit() once.
template <class real> PLIANT_INLINE Wide3<real> unpack_bonds(WideInt<real> word) {
  const WideInt<real> top = static_cast<std::int32_t>(0xFFC00000u) - WideInt<real>{};
  return {__builtin_convertvector(word << 22, Wide<real>),
          __builtin_convertvector((word << 12) & top, Wide<real>),
          __builtin_convertvector((word << 2) & top, Wide<real>)};
}
template <class real> PLIANT_INLINE real grid_unit(real unit) {
  return unit * real(0x1p-22);
}

/// Calls visit(neighbours, xi, c_out, c_in) for every bond of a part, xi in grid units; padding has no
/// weight.
template <class View, class Visit>
PLIANT_INLINE void for_each_bond_of_part(const View& k, uint local, Visit visit) {
  using real = typename View::real;
  const uint slice = k.first_slice + local / 16, lane = local % 16;
  for (std::size_t row = k.slice_begin[slice], end = k.slice_begin[slice + 1]; row < end; ++row) {
    const uint* const neighbours = k.bond + 32 * row + lane;
    const real* const weights = k.weight + 32 * row + lane;
    visit(neighbours, unpack_bonds<real>(load_words<real>(neighbours + 16)), load_wide(weights),
          load_wide(weights + 16));
  }
}

} // namespace pliant::openmp::PLIANT_ISA
