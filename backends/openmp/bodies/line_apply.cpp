// See kernels/line_apply.decl.
#include "kernels/line_apply.h"
#include "backends/openmp/body.h"
#include "backends/openmp/simd.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void line_apply(const kernels::line_apply::View<real>& k) {
  const real action = k.solver[SOLVER_ACTION];
  if (action == 0) return;
  const real factor = action == 2 ? k.solver[SOLVER_FACTOR] : real(0);
#pragma omp parallel for schedule(static)
  for (uint i = 0; i < k.threads; ++i) {
    if (action == 1) {
      k.best_iterate[i] = k.displacement[i];
      continue;
    }
    if (action == 4) {
      if (!(k.inertia_target[i].w < 0)) k.displacement[i] = {0, 0, 0, 0};
      continue;
    }
    const Quad<real> best = load_quad(k.best_iterate[i]), u = load_quad(k.displacement[i]);
    store_quad(k.displacement[i], action == 2 ? best + factor * (u - best) : best);
  }
}

PLIANT_BODY(line_apply)

} // namespace pliant::openmp::PLIANT_ISA
