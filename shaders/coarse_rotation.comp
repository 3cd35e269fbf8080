// See kernels/coarse_rotation.decl.
#include "common/solver.glsl"

void main() {
  uint local = thread_index();
  if (local >= threads || solver[SOLVER_TAKEN] == 0.0 || solver[SOLVER_LINEAR] == 0.0) return;
  uint c = first_cell + local, begin = child_begin[c];
#if particles
  vec4 lead = rotation[child[begin]];
#else
  vec4 lead = cell_rotation[child[begin]];
#endif
  vec4 sum = lead;
  for (uint k = begin + 1u; k < child_begin[c + 1u]; ++k) {
#if particles
    vec4 q = rotation[child[k]];
#else
    vec4 q = cell_rotation[child[k]];
#endif
    sum += dot(q, lead) < 0.0 ? -q : q;
  }
  cell_rotation[c] = sum;
}
