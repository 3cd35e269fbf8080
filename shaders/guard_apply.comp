// Keeps or restores the best iterate, or stands still; see kernels/guard_apply.decl.
#include "common/solver.glsl"

void main() {
  uint i = thread_index();
  if (i >= threads) return;
  float action = solver[SOLVER_ACTION];
  if (action == 1.0 || action == 3.0) {
    best_iterate[i] = earlier_iterate[i];
    if (action == 3.0 && inertia_target[i].w >= 0.0) {
      displacement[i] = vec4(0.0);
      earlier_iterate[i] = vec4(0.0);
    }
  } else if (action == 2.0) {
    displacement[i] = best_iterate[i];
    earlier_iterate[i] = best_iterate[i];
  }
}
