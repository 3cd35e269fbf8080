// See kernels/conjugate_direction.decl.
#include "kernels/conjugate_direction.h"
#include "backends/openmp/body.h"
#include "backends/openmp/simd.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void conjugate_direction(const kernels::conjugate_direction::View<real>& k) {
  const real action = k.solver[SOLVER_ACTION], keep = k.solver[SOLVER_CG_KEEP];
  if (action == 0) return;
  const bool first = k.solver[SOLVER_INNER] == 0;
#pragma omp parallel for schedule(static)
  for (uint i = 0; i < k.threads; ++i) {
    if (action == 2) {
      store_quad(k.displacement[i], load_quad(k.best_iterate[i]) + load_quad(k.descent[i]));
    } else if (first) {
      k.direction[i] = k.preconditioned[i];
      k.descent[i] = {0, 0, 0, 0};
    } else {
      store_quad(k.direction[i], load_quad(k.preconditioned[i]) + keep * load_quad(k.direction[i]));
    }
  }
}

PLIANT_BODY(conjugate_direction)

} // namespace pliant::openmp::PLIANT_ISA
