// See kernels/residual.decl.
#include "common/solver.glsl"

shared vec4 group_sum[128];
shared vec2 group_scale[128];

void main() {
  uint i = thread_index();
  if (solver[SOLVER_STOP] > 0.0) return;
  vec4 sums = vec4(0.0);
  vec2 scale = vec2(0.0);
  if (i < threads) {
    vec4 target = inertia_target[i], f = force[i], result = vec4(0.0);
    vec3 u = displacement[i].xyz;
    if (target.w >= 0.0) {
      vec3 away = target.xyz - u, r = target.w * away + f.xyz;
      result = vec4(r, 1.0 / (target.w + relief * f.w));
      sums.x = dot(r, r) / (target.w + f.w);
      sums.y = 0.5 * target.w * dot(away, away);
      sums.z = dot(r, u - best_iterate[i].xyz);
      scale = vec2(target.w * target.w * dot(target.xyz, target.xyz) / (target.w + f.w), (target.w + f.w) * dot(u, u));
    }
#if potential
    sums.y += energy[i];
#endif
    residual[i] = result;
  }
  uint lane = gl_LocalInvocationIndex;
  group_sum[lane] = sums;
  group_scale[lane] = scale;
  barrier();
  for (uint half_width = 64; half_width > 0; half_width /= 2) {
    if (lane < half_width) {
      group_sum[lane] += group_sum[lane + half_width];
      group_scale[lane] += group_scale[lane + half_width];
    }
    barrier();
  }
  if (lane != 0) return;
  solve_partial[group_index()] = group_sum[0];
  solve_partial[(threads + 127) / 128 + group_index()] = vec4(group_scale[0], 0.0, 0.0);
}
