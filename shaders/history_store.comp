// See kernels/history_store.decl.
#include "common/solver.glsl"

void main() {
  uint i = thread_index();
  if (i >= threads || solver[SOLVER_TAKEN] == 0.0) return;
  uint slot = (uint(solver[SOLVER_NEWEST]) + 1u) % uint(MEMORY);
  vec3 r = residual[i].xyz;
  history[(HISTORY_STEP + slot) * stride + i] = vec4(displacement[i].xyz - best_iterate[i].xyz, 0.0);
  history[(HISTORY_CHANGE + slot) * stride + i] = vec4(history[HISTORY_RESIDUAL * stride + i].xyz - r, 0.0);
  history[HISTORY_RESIDUAL * stride + i] = vec4(r, 0.0);
}
