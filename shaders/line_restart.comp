// See kernels/line_restart.decl.
#include "common/solver.glsl"

void main() {
  if (thread_index() != 0u || solver[SOLVER_STOP] == 1.0) return;
  solver[SOLVER_STOP] = 0.0;
  solver[SOLVER_LINEAR] = 0.0;
}
