// See kernels/newton_product.decl.
#include "common/solver.glsl"

shared vec4 group_sum[128];

void main() {
  uint i = thread_index();
  if (solver[SOLVER_LINEAR] == 0.0) return;
  vec4 sums = vec4(0.0);
  if (i < threads) {
    vec3 p = direction[i].xyz, q = vec3(0.0);
    float inertia = inertia_target[i].w;
    if (inertia >= 0.0) {
      q = inertia * p - force[i].xyz;
#if obstacles
      vec4 a = contact_block[2 * i], b = contact_block[2 * i + 1];
      q += vec3(a.x * p.x + a.y * p.y + a.z * p.z, a.y * p.x + a.w * p.y + b.x * p.z, a.z * p.x + b.x * p.y + b.y * p.z);
#endif
    }
    force[i].xyz = q;
    sums.x = dot(p, q);
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
