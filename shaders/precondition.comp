// See kernels/precondition.decl.
#include "common/solver.glsl"

shared vec4 group_sum[128];

void main() {
  uint i = thread_index();
  if (solver[SOLVER_LINEAR] == 0.0) return;
  vec4 sums = vec4(0.0);
  if (i < threads) {
    vec4 r = residual[i];
    vec3 z = r.w * r.xyz;
#if multilevel
    if (r.w > 0.0) {
      uint base = i / 16u * 128u + i % 16u;
      for (uint k = 0u; k < 8u; ++k)
        z += particle_weight[base + 16u * k] * coarse_result[particle_node[base + 16u * k]].xyz;
    }
#endif
    preconditioned[i] = vec4(z, 0.0);
    sums.x = dot(r.xyz, z);
  }
  uint lane = gl_LocalInvocationIndex;
  group_sum[lane] = sums;
  barrier();
  for (uint half_width = 64; half_width > 0; half_width /= 2) {
    if (lane < half_width) group_sum[lane] += group_sum[lane + half_width];
    barrier();
  }
  if (lane == 0) solve_partial[group_index()] = group_sum[0];
}
