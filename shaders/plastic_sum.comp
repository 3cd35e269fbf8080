// One row for the step; see kernels/plastic_sum.decl.
#include "common/group_sum.glsl"

shared vec2 group_largest[128];

void main() {
  uint lane = gl_LocalInvocationIndex;
  vec4 sum = vec4(0.0);
  vec2 largest = vec2(0.0);
  for (uint i = lane; i < particle_count; i += 128) {
    sum += vec4(flow[2 * i].w, flow[2 * i].y, flow[2 * i].z, 0.0);
    vec4 stays = flow[2 * i + 1];
    largest = max(largest, vec2(flow[2 * i].x, 1.0 - min(stays.y, stays.z)));
  }
  sum = sum_over_group(sum);
  group_largest[lane] = largest;
  barrier();
  for (uint half_width = 64; half_width > 0; half_width /= 2) {
    if (lane < half_width) group_largest[lane] = max(group_largest[lane], group_largest[lane + half_width]);
    barrier();
  }
  if (lane != 0) return;
  plastic_row[5 * row] = sum.x;
  plastic_row[5 * row + 1] = sum.y;
  plastic_row[5 * row + 2] = group_largest[0].x;
  plastic_row[5 * row + 3] = sum.z;
  plastic_row[5 * row + 4] = group_largest[0].y;
}
