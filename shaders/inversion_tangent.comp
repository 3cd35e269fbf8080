// See kernels/inversion_tangent.decl.
#include "common/solver.glsl"

void main() {
  uint local = thread_index();
  if (local >= threads || solver[SOLVER_TAKEN] == 0.0 || solver[SOLVER_LINEAR] == 0.0) return;
  uint i = first + local;
  inverted[i] = inversion[3 * i].w > 0.0 ? 1.0 : 0.0;
}
