// See kernels/history_direction.decl.
#include "kernels/history_direction.h"
#include "backends/openmp/body.h"
#include "backends/openmp/simd.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void history_direction(const kernels::history_direction::View<real>& k) {
  if (k.solver[SOLVER_ACTION] == 0) return;
  const real keep = k.solver[SOLVER_KEEP_Z];
  const bool any = k.remembers && k.solver[SOLVER_HISTORY] > 0;
  const Quad<real> no_w{1, 1, 1, 0};
#pragma omp parallel for schedule(static)
  for (uint i = 0; i < k.threads; ++i) {
    Quad<real> d = keep * load_quad(k.preconditioned[i]);
    for (uint slot = 0; any && slot < MEMORY; ++slot) {
      const real a = k.solver[SOLVER_KEEP_STEP + slot], b = k.solver[SOLVER_KEEP_IMAGE + slot];
      if (a == 0 && b == 0) continue; // an empty slot
      d += a * load_quad(k.history[std::size_t{HISTORY_STEP + slot} * k.stride + i]) +
           b * load_quad(k.history[std::size_t{HISTORY_IMAGE + slot} * k.stride + i]);
    }
    store_quad(k.displacement[i], (load_quad(k.best_iterate[i]) + d) * no_w);
  }
}

PLIANT_BODY(history_direction)

} // namespace pliant::openmp::PLIANT_ISA
