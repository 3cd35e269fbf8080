// See kernels/conjugate_direction.decl.
#include "common/solver.glsl"

void main() {
  uint i = thread_index();
  float action = solver[SOLVER_ACTION];
  if (i >= threads || action == 0.0) return;
  if (action == 2.0) {
    displacement[i] = best_iterate[i] + descent[i];
  } else if (solver[SOLVER_INNER] == 0.0) {
    direction[i] = preconditioned[i];
    descent[i] = vec4(0.0);
  } else {
    direction[i] = preconditioned[i] + solver[SOLVER_CG_KEEP] * direction[i];
  }
}
