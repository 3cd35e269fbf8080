// See kernels/coarse_interpolate.decl.
#include "common/solver.glsl"

void main() {
  uint local = thread_index();
  if (local >= threads || solver[SOLVER_LINEAR] == 0.0) return;
  uint n = first_node + local, base = n / 16u * 128u + n % 16u;
  vec3 x = coarse_iterate[n].xyz;
  for (uint k = 0u; k < 8u; ++k)
    x += parent_weight[base + 16u * k] * coarse_result[node_parent[base + 16u * k]].xyz;
  coarse_iterate[n] = vec4(x, 0.0);
}
