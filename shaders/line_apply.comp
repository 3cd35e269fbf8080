// See kernels/line_apply.decl.
#include "common/solver.glsl"

void main() {
  uint i = thread_index();
  if (i >= threads) return;
  float action = solver[SOLVER_ACTION];
  if (action == 1.0)
    best_iterate[i] = displacement[i];
  else if (action == 2.0)
    displacement[i] = best_iterate[i] + solver[SOLVER_FACTOR] * (displacement[i] - best_iterate[i]);
  else if (action == 3.0)
    displacement[i] = best_iterate[i];
  else if (action == 4.0 && inertia_target[i].w >= 0.0)
    displacement[i] = vec4(0.0);
}
