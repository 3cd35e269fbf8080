// One row for the step; see kernels/fluid_sum.decl.
#include "common/group_sum.glsl"

shared float group_largest[128];

void main() {
  uint lane = gl_LocalInvocationIndex;
  vec4 sum = vec4(0.0), excess = vec4(0.0);
  float largest = -1.0;
  for (uint i = lane; i < place_count; i += 128) {
    vec4 seen = fluid_measure[i];
    if (seen.w == 0.0) continue;
    sum.xyz += vec3(seen.z, seen.z * abs(seen.x), seen.y);
    excess.xy += vec2(max(seen.x, 0.0), 1.0);
    largest = max(largest, seen.x);
  }
  for (uint i = lane; i < particle_count; i += 128) sum.w += position[i].w == 0.0 ? 1.0 : 0.0;
  sum = sum_over_group(sum);
  excess = sum_over_group(excess);
  group_largest[lane] = largest;
  barrier();
  for (uint half_width = 64; half_width > 0; half_width /= 2) {
    if (lane < half_width) group_largest[lane] = max(group_largest[lane], group_largest[lane + half_width]);
    barrier();
  }
  if (lane != 0) return;
  uint to = 8 * row;
  fluid_row[to] = sum.x;
  fluid_row[to + 1] = sum.y;
  fluid_row[to + 2] = group_largest[0];
  fluid_row[to + 3] = sum.z;
  fluid_row[to + 4] = sum.w;
  fluid_row[to + 5] = float(left_out[0]);
  fluid_row[to + 6] = float(left_out[1]);
  fluid_row[to + 7] = excess.y > 0.0 ? excess.x / excess.y : 0.0;
}
