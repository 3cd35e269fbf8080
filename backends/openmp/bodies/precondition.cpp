// See kernels/precondition.decl.
#include "kernels/precondition.h"
#include "backends/openmp/body.h"
#include "backends/openmp/simd.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void precondition(const kernels::precondition::View<real>& k) {
  if (k.solver[SOLVER_LINEAR] == 0) return;
  constexpr uint group = kernels::precondition::group_size;
  const Quad<real> no_w{1, 1, 1, 0};
#pragma omp parallel for schedule(static)
  for (uint block = 0; block < (k.threads + group - 1) / group; ++block) {
    Quad<real> sum{};
    for (uint i = group * block; i < smaller(group * (block + 1), k.threads); ++i) {
      const Quad<real> r = load_quad(k.residual[i]);
      Quad<real> z = r[3] * r;
      if (k.multilevel && r[3] > 0) {
        const std::size_t base = std::size_t{i / 16} * 128 + i % 16;
        for (std::size_t at = base; at < base + 128; at += 16)
          z += k.particle_weight[at] * load_quad(k.coarse_result[k.particle_node[at]]);
      }
      z *= no_w;
      store_quad(k.preconditioned[i], z);
      sum += r * z;
    }
    k.solve_partial[block] = {sum[0] + sum[1] + sum[2], 0, 0, 0};
  }
}

PLIANT_BODY(precondition)

} // namespace pliant::openmp::PLIANT_ISA
