// See kernels/conjugate_update.decl.
#include "common/solver.glsl"

void main() {
  uint i = thread_index();
  float action = solver[SOLVER_ACTION];
  if (i >= threads || action == 0.0) return;
  float along = solver[SOLVER_CG_STEP];
  vec4 step = descent[i] + along * direction[i];
  descent[i] = step;
  if (action == 2.0)
    displacement[i] = best_iterate[i] + step;
  else
    residual[i].xyz -= along * force[i].xyz;
}
