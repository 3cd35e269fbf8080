// What a solve with a factor found; see kernels/factor_dot.decl.
#include "kernels/factor_dot.h"
#include "backends/openmp/body.h"
#include "backends/openmp/simd.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void factor_dot(const kernels::factor_dot::View<real>& k) {
  if (k.solver[SOLVER_LINEAR] == 0) return;
  constexpr uint group = kernels::factor_dot::group_size;
#pragma omp parallel for schedule(static)
  for (uint block = 0; block < (k.threads + group - 1) / group; ++block) {
    Quad<real> sum{};
    for (uint i = group * block; i < smaller(group * (block + 1), k.threads); ++i) {
      const Quad<real> r = load_quad(k.residual[i]);
      if (r[3] == 0)
        store_quad(k.preconditioned[i], Quad<real>{});
      else
        sum += r * load_quad(k.preconditioned[i]);
    }
    k.solve_partial[block] = {sum[0] + sum[1] + sum[2], 0, 0, 0};
  }
}

PLIANT_BODY(factor_dot)

} // namespace pliant::openmp::PLIANT_ISA
