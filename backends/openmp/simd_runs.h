// Wide values of places that follow one another, and squares of words.
#pragma once

#include "backends/openmp/simd.h"

namespace pliant::openmp::PLIANT_ISA {

/// first, first + 1, ...
template <class real> PLIANT_INLINE WideInt<real> counted(uint first) {
  const auto from = [&]<int... k>(std::integer_sequence<int, k...>)->WideInt<real> {
    return static_cast<std::int32_t>(first) + WideInt<real>{k...};
  };
  return from(std::make_integer_sequence<int, lanes<real>>());
}

/// Places that follow one another, as x, y, z, w.
template <class real> PLIANT_INLINE Wide4<real> gather_run(const Real4<real>* base) {
  const auto row = [&]<uint first>(std::integral_constant<uint, first>) -> Wide<real> {
    const auto quad = [&](uint lane) { return load_quad(base[first + lane]); };
    if constexpr (lanes<real> == 4) {
      return quad(0);
    } else if constexpr (lanes<real> == 8) {
      return joined<Wide<real>>(quad(0), quad(4));
    } else {
      using Half = typename VectorOf<real, 8 * sizeof(real)>::Type;
      return joined<Wide<real>>(joined<Half>(quad(0), quad(4)), joined<Half>(quad(8), quad(12)));
    }
  };
  return transposed<real>({row(std::integral_constant<uint, 0>()), row(std::integral_constant<uint, 1>()),
                           row(std::integral_constant<uint, 2>()), row(std::integral_constant<uint, 3>())});
}

/// Transposes a square of words, as wide as a register of them. Each pass swaps the halves of ever longer
/// pieces.
template <uint apart = 1> PLIANT_INLINE void turn(WideInt<float> (&block)[lanes<float>]) {
  constexpr int wide = lanes<float>;
  struct Halves {
    static constexpr int low(int k) {
      return k & static_cast<int>(apart) ? wide + k - static_cast<int>(apart) : k;
    }
    static constexpr int high(int k) {
      return k & static_cast<int>(apart) ? wide + k : k + static_cast<int>(apart);
    }
  };
  const auto swap = [&]<int... k>(uint one, uint two, std::integer_sequence<int, k...>) {
    const WideInt<float> a = block[one], b = block[two];
    block[one] = __builtin_shufflevector(a, b, Halves::low(k)...);
    block[two] = __builtin_shufflevector(a, b, Halves::high(k)...);
  };
  for (uint first = 0; first < wide; ++first)
    if (!(first & apart)) swap(first, first + apart, std::make_integer_sequence<int, wide>());
  if constexpr (2 * apart < wide) turn<2 * apart>(block);
}

/// Stores to whole registers' addresses that leave the caches alone: for what is written once and is more
/// than these hold. flush_stores() makes them seen.
PLIANT_INLINE void store_past_caches(uint* to, WideInt<float> value) {
#if defined(__AVX512F__) && defined(__AVX512DQ__)
  _mm512_stream_si512((__m512i*)to, (__m512i)value);
#elif defined(__AVX2__)
  _mm256_stream_si256((__m256i*)to, (__m256i)value);
#else
  __builtin_memcpy(to, &value, sizeof value);
#endif
}
PLIANT_INLINE void flush_stores() {
#if defined(__AVX2__)
  _mm_sfence();
#endif
}

} // namespace pliant::openmp::PLIANT_ISA
