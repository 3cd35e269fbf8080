// See kernels/ordinary_tangent.decl.
#include "common/solver.glsl"

void main() {
  uint local = thread_index();
  if (local >= threads || solver[SOLVER_TAKEN] == 0.0 || solver[SOLVER_LINEAR] == 0.0) return;
  uint i = first + local;
  vec4 u = extension[i];
  tangent[4 * i] = vec4(position[i].xyz + u.xyz, u.w);
}
