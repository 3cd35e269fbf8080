// See kernels/history_direction.decl.
#include "common/solver.glsl"

void main() {
  uint i = thread_index();
  if (i >= threads || solver[SOLVER_ACTION] == 0.0) return;
  vec3 d = solver[SOLVER_KEEP_Z] * preconditioned[i].xyz;
#if remembers
  if (solver[SOLVER_HISTORY] > 0.0)
    for (uint slot = 0u; slot < uint(MEMORY); ++slot) {
      float a = solver[SOLVER_KEEP_STEP + slot], b = solver[SOLVER_KEEP_IMAGE + slot];
      if (a == 0.0 && b == 0.0) continue; // an empty slot
      d += a * history[(HISTORY_STEP + slot) * stride + i].xyz + b * history[(HISTORY_IMAGE + slot) * stride + i].xyz;
    }
#endif
  displacement[i] = vec4(best_iterate[i].xyz + d, 0.0);
}
