// Products of a factor's blocks of 16 outputs with vectors of three components, for blocks that share their
// inputs; see engine/solver/cholesky.h.
#pragma once

#include "backends/openmp/simd.h"

namespace pliant::openmp::PLIANT_ISA {

inline constexpr uint factor_run = 8;   ///< blocks worked off together
inline constexpr uint factor_tile = 64; ///< inputs fetched together

/// Inputs in turn, each component for itself.
template <class real> struct FactorInputs { real x[factor_tile], y[factor_tile], z[factor_tile]; };
template <class real> PLIANT_INLINE void put(FactorInputs<real>& to, uint k, const Quad<real>& value) {
  to.x[k] = value[0], to.y[k] = value[1], to.z[k] = value[2];
}

/// Sums of one block: component c of output `lane` at [16 c + lane].
template <class real> struct alignas(64) FactorSums { real at[48]; };

/// Adds inputs [from, to) of a tile; `coefficients` are those of the tile's input `from`.
template <class real>
PLIANT_INLINE void add_products(FactorSums<real>& sums, const real* __restrict coefficients,
                                const FactorInputs<real>& in, uint from, uint to) {
  constexpr uint width = lanes<real>;
  for (uint part = 0; part < 16; part += 2 * width) {
    constexpr uint second = width < 16 ? width : 0; // a register may hold the whole block
    Wide<real> x0 = load_wide(sums.at + part), y0 = load_wide(sums.at + 16 + part),
               z0 = load_wide(sums.at + 32 + part), x1 = load_wide(sums.at + part + second),
               y1 = load_wide(sums.at + 16 + part + second), z1 = load_wide(sums.at + 32 + part + second);
    for (uint k = from; k < to; ++k) {
      const real* const a = coefficients + std::size_t{16} * (k - from) + part;
      const Wide<real> low = load_wide(a);
      x0 += low * in.x[k], y0 += low * in.y[k], z0 += low * in.z[k];
      if constexpr (second != 0) {
        const Wide<real> high = load_wide(a + second);
        x1 += high * in.x[k], y1 += high * in.y[k], z1 += high * in.z[k];
      }
    }
    store_reals(sums.at + part, width, x0), store_reals(sums.at + 16 + part, width, y0),
        store_reals(sums.at + 32 + part, width, z0);
    if constexpr (second != 0)
      store_reals(sums.at + part + second, width, x1), store_reals(sums.at + 16 + part + second, width, y1),
          store_reals(sums.at + 32 + part + second, width, z1);
  }
}

} // namespace pliant::openmp::PLIANT_ISA
