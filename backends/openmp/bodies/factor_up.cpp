// One level of the way up in solving with a factor; see kernels/factor_up.decl.
#include "kernels/factor_up.h"
#include "backends/openmp/body.h"
#include "backends/openmp/factor.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void factor_up(const kernels::factor_up::View<real>& k) {
  if (k.solver[SOLVER_LINEAR] == 0) return;
  const uint blocks = k.threads / 16, runs = (blocks + factor_run - 1) / factor_run;
#pragma omp parallel for schedule(dynamic, 1)
  for (uint run = 0; run < runs; ++run) {
    const uint end = smaller(factor_run * (run + 1), blocks);
    for (uint first = factor_run * run, last = first; first < end; first = last) {
      const Uint4* const block = k.factor_block + k.first_block + first;
      while (last < end && k.factor_block[k.first_block + last].y == block->y) ++last; // of one front
      const uint count = last - first, slot0 = block->y, inputs = block[count - 1].z;
      FactorSums<real> sums[factor_run] = {};
      FactorInputs<real> in;
      for (uint tile = 0; tile < inputs; tile += factor_tile) {
        const uint width = smaller(factor_tile, inputs - tile);
        for (uint m = 0; m < width; ++m) {
          const Uint4 source = k.factor_slot[slot0 + tile + m];
          put<real>(in, m,
                    load_quad(k.residual[source.x]) +
                        (load_quad(k.front[source.y]) + load_quad(k.front[source.z])));
        }
        for (uint b = 0; b < count; ++b)
          if (block[b].z > tile)
            add_products(sums[b], k.factor + std::size_t{16} * (block[b].x + tile), in, 0,
                         smaller(width, block[b].z - tile));
      }
      for (uint b = 0; b < count; ++b)
        for (uint lane = 0; lane < 16; ++lane) {
          const uint own = slot0 + block[b].w + lane;
          const Uint4 slot = k.factor_slot[own];
          Quad<real> value{sums[b].at[lane], sums[b].at[16 + lane], sums[b].at[32 + lane], 0};
          if (slot.w == 0) value += load_quad(k.front[slot.y]) + load_quad(k.front[slot.z]);
          store_quad(k.front[own], value);
        }
    }
  }
}

PLIANT_BODY(factor_up)

} // namespace pliant::openmp::PLIANT_ISA
