// See kernels/conjugate_update.decl.
#include "kernels/conjugate_update.h"
#include "backends/openmp/body.h"
#include "backends/openmp/simd.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void conjugate_update(const kernels::conjugate_update::View<real>& k) {
  const real action = k.solver[SOLVER_ACTION], along = k.solver[SOLVER_CG_STEP];
  if (action == 0) return;
  const Quad<real> no_w{1, 1, 1, 0};
#pragma omp parallel for schedule(static)
  for (uint i = 0; i < k.threads; ++i) {
    const Quad<real> step = load_quad(k.descent[i]) + along * load_quad(k.direction[i]);
    store_quad(k.descent[i], step);
    if (action == 2)
      store_quad(k.displacement[i], load_quad(k.best_iterate[i]) + step);
    else
      store_quad(k.residual[i], load_quad(k.residual[i]) - along * load_quad(k.force[i]) * no_w);
  }
}

PLIANT_BODY(conjugate_update)

} // namespace pliant::openmp::PLIANT_ISA
