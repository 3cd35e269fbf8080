// Keeps or restores the best iterate; see kernels/guard_apply.decl.
#include "kernels/guard_apply.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void guard_apply(const kernels::guard_apply::View<real>& k) {
  const real action = k.solver[SOLVER_ACTION];
  if (action == 0) return;
  if (action == 1 || action == 3) {
#pragma omp parallel for schedule(static)
    for (uint i = 0; i < k.threads; ++i) {
      k.best_iterate[i] = k.earlier_iterate[i];
      if (action == 1 || k.inertia_target[i].w < 0) continue;
      k.displacement[i] = {0, 0, 0, 0};
      k.earlier_iterate[i] = {0, 0, 0, 0};
    }
  } else {
#pragma omp parallel for schedule(static)
    for (uint i = 0; i < k.threads; ++i) {
      k.displacement[i] = k.best_iterate[i];
      k.earlier_iterate[i] = k.best_iterate[i];
    }
  }
}

PLIANT_BODY(guard_apply)

} // namespace pliant::openmp::PLIANT_ISA
