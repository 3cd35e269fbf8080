// See kernels/factor_dot.decl.
#include "common/solver.glsl"

shared float group_sum[128];

void main() {
  uint i = thread_index(), lane = gl_LocalInvocationIndex;
  if (solver[SOLVER_LINEAR] == 0.0) return;
  float product = 0.0;
  if (i < threads) {
    vec4 r = residual[i];
    if (r.w == 0.0) preconditioned[i] = vec4(0.0);
    else product = dot(r.xyz, preconditioned[i].xyz);
  }
  group_sum[lane] = product;
  barrier();
  for (uint half_width = 64u; half_width > 0u; half_width /= 2u) {
    if (lane < half_width) group_sum[lane] += group_sum[lane + half_width];
    barrier();
  }
  if (lane == 0u) solve_partial[group_index()] = vec4(group_sum[0], 0.0, 0.0, 0.0);
}
