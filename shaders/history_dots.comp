// See kernels/history_dots.decl.
#include "common/solver.glsl"

shared float group_sum[128];

void main() {
  uint i = thread_index(), lane = gl_LocalInvocationIndex;
  if (solver[SOLVER_LINEAR] == 0.0) return;
  uint newest = (uint(solver[SOLVER_NEWEST]) + 1u) % uint(MEMORY);
  float found[HISTORY_DOTS];
  for (int d = 0; d < HISTORY_DOTS; ++d) found[d] = 0.0;
  if (i < threads) {
    vec3 r = residual[i].xyz, z = preconditioned[i].xyz;
    vec3 image = history[HISTORY_PRECONDITIONED * stride + i].xyz - z;
    history[(HISTORY_IMAGE + newest) * stride + i] = vec4(image, 0.0);
    history[HISTORY_PRECONDITIONED * stride + i] = vec4(z, 0.0);
    vec3 step_new = history[(HISTORY_STEP + newest) * stride + i].xyz;
    vec3 change_new = history[(HISTORY_CHANGE + newest) * stride + i].xyz;
    for (uint slot = 0u; slot < uint(MEMORY); ++slot) {
      vec3 s = history[(HISTORY_STEP + slot) * stride + i].xyz, y = history[(HISTORY_CHANGE + slot) * stride + i].xyz;
      vec3 own = slot == newest ? image : history[(HISTORY_IMAGE + slot) * stride + i].xyz;
      found[5u * slot] = dot(s, r);
      found[5u * slot + 1u] = dot(own, r);
      found[5u * slot + 2u] = dot(s, change_new);
      found[5u * slot + 3u] = dot(step_new, y);
      found[5u * slot + 4u] = dot(y, image);
    }
  }
  for (int d = 0; d < HISTORY_DOTS; ++d) {
    group_sum[lane] = found[d];
    barrier();
    for (uint half_width = 64; half_width > 0; half_width /= 2) {
      if (lane < half_width) group_sum[lane] += group_sum[lane + half_width];
      barrier();
    }
    if (lane == 0) history_partial[HISTORY_DOTS * group_index() + uint(d)] = group_sum[0];
    barrier();
  }
}
