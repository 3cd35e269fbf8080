// One row for the step; see kernels/fluid_bond_sum.decl.
#include "common/group_sum.glsl"

#if plastic
shared vec2 group_largest[128];
#endif

void main() {
  uint lane = local_index();
  vec4 sum = vec4(0.0);
  vec2 largest = vec2(0.0);
  for (uint i = lane; i < place_count; i += 128u) {
    sum.w += fluid_energy[i];
#if plastic
    vec4 flow = fluid_flow[2u * i], stays = fluid_flow[2u * i + 1u];
    sum.xyz += vec3(flow.w, flow.y, flow.z);
    largest = max(largest, vec2(flow.x, 1.0 - min(stays.y, stays.z)));
#endif
  }
  sum = sum_over_group(sum);
#if plastic
  group_largest[lane] = largest;
  barrier();
  for (uint half_width = 64u; half_width > 0u; half_width /= 2u) {
    if (lane < half_width) group_largest[lane] = max(group_largest[lane], group_largest[lane + half_width]);
    barrier();
  }
  largest = group_largest[0];
#endif
  if (lane != 0u) return;
  bond_row[6u * row] = sum.x;
  bond_row[6u * row + 1u] = sum.y;
  bond_row[6u * row + 2u] = largest.x;
  bond_row[6u * row + 3u] = sum.z;
  bond_row[6u * row + 4u] = largest.y;
  bond_row[6u * row + 5u] = sum.w;
}
