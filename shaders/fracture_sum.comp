// One row for the step; see kernels/fracture_sum.decl.
#include "common/group_sum.glsl"

void main() {
  uint lane = gl_LocalInvocationIndex;
  vec4 sum = vec4(0.0);
  for (uint i = lane; i < particle_count; i += 128) sum += vec4(shape[broken_at + i], released[i], 0.0, 0.0);
  sum = sum_over_group(sum);
  if (lane != 0) return;
  fracture[2 * row] = 0.5 * sum.x;
  fracture[2 * row + 1] = sum.y;
}
