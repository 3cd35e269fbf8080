// One level of the way down in solving with a factor; see kernels/factor_down.decl.
#include "kernels/factor_down.h"
#include "backends/openmp/body.h"
#include "backends/openmp/factor.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void factor_down(const kernels::factor_down::View<real>& k) {
  if (k.solver[SOLVER_LINEAR] == 0) return;
  const uint blocks = k.threads / 16;
  constexpr uint run = factor_run / 2; // inputs are many, outputs few
#pragma omp parallel for schedule(dynamic, 1)
  for (uint begin = 0; begin < blocks; begin += run) {
    const uint end = smaller(begin + run, blocks);
    for (uint first = begin, last = first; first < end; first = last) {
      const Uint4* const block = k.factor_block + k.first_block + first;
      while (last < end && k.factor_block[k.first_block + last].y == block->y) ++last; // of one front
      const uint count = last - first, slot0 = block->y, inputs = block->z;
      FactorSums<real> sums[run] = {};
      FactorInputs<real> in;
      for (uint tile = block->w; tile < inputs; tile += factor_tile) {
        const uint width = smaller(factor_tile, inputs - tile);
        for (uint m = 0; m < width; ++m) {
          const Uint4 slot = k.factor_slot[slot0 + tile + m];
          put<real>(in, m, load_quad(slot.w != 0 ? k.front[slot0 + tile + m] : k.preconditioned[slot.x]));
        }
        for (uint b = 0; b < count; ++b) {
          const uint from = block[b].w > tile ? block[b].w - tile : 0;
          if (from < width)
            add_products(sums[b], k.factor + std::size_t{16} * (block[b].x + tile + from - block[b].w), in,
                         from, width);
        }
      }
      for (uint b = 0; b < count; ++b)
        for (uint lane = 0; lane < 16; ++lane) {
          const Uint4 own = k.factor_slot[slot0 + block[b].w + lane];
          if (own.w == 0) continue; // beyond the last column
          k.preconditioned[own.x] = {sums[b].at[lane], sums[b].at[16 + lane], sums[b].at[32 + lane], 0};
        }
    }
  }
}

PLIANT_BODY(factor_down)

} // namespace pliant::openmp::PLIANT_ISA
