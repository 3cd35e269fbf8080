// Sums of one chunk; see kernels/statistics_chunk.decl.
#include "common/group_sum.glsl"

shared vec2 group_largest[128];

void main() {
  uint group = group_index(), lane = gl_LocalInvocationIndex;
  if (group >= threads / 128) return;
  uint first = chunk[group].x, end = chunk[group].y;
  vec4 sums = vec4(0.0), momentum = vec4(0.0);
  vec2 largest = vec2(0.0);
  for (uint i = first + lane; i < end; i += 128) {
    float m = position[i].w, v2 = dot(velocity[i].xyz, velocity[i].xyz);
    vec3 u = displacement[i].xyz;
    float elastic = 0.0;
#if energies
    elastic = energy[i];
#endif
    float check = v2 + elastic + dot(position[i].xyz, vec3(1.0)) + dot(u, u);
    bool finite = !(isnan(check) || isinf(check));
    sums += vec4(0.5 * m * v2, elastic, 0.0, finite ? 0.0 : 1.0);
    momentum.xyz += m * velocity[i].xyz;
    if (finite) largest = max(largest, vec2(v2, dot(u, u)));
  }
  sums = sum_over_group(sums);
  momentum = sum_over_group(momentum);
  group_largest[lane] = largest;
  barrier();
  for (uint half_width = 64; half_width > 0; half_width /= 2) {
    if (lane < half_width) group_largest[lane] = max(group_largest[lane], group_largest[lane + half_width]);
    barrier();
  }
  if (lane != 0) return;
  chunk_sum[2 * group] = vec4(sums.xy, group_largest[0].x, sums.w);
  chunk_sum[2 * group + 1] = vec4(momentum.xyz, group_largest[0].y);
}
