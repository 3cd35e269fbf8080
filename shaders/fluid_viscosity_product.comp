// The matrix of viscosity; see kernels/fluid_viscosity_product.decl.
#include "common/fluid_viscosity.glsl"
#include "common/group_sum.glsl"
#include "common/near.glsl"

void main() {
  uint i = thread_index();
  if (fluid_viscosity[VISCOSITY_STOP] > 0.0) return;
  vec4 sums = vec4(0.0);
  if (i < threads) {
    vec4 u = fluid_residual[i];
    vec3 w = u.xyz;
    uint slice = i / 16u, first = 16u * rows * slice + i % 16u, count = near_count[slice];
#if central
    vec3 period = vec3(period_x, period_y, period_z), place = fluid_start[i].xyz;
#endif
    for (uint r = 0u; r < count; ++r) {
      uint j = near[first + 16u * r];
      vec3 faster = u.xyz - fluid_residual[j].xyz;
#if central
      vec3 arm = shortest(place - fluid_start[j].xyz, period);
      faster = dot(arm, faster) * arm;
#endif
      w += near_rate[first + 16u * r] * faster;
    }
    fluid_image[i] = vec4(w, 0.0);
    sums.xy = u.w * vec2(dot(u.xyz, u.xyz), dot(u.xyz, w));
  }
  sums = sum_over_group(sums);
  if (local_index() == 0u) fluid_partial[group_index()] = sums;
}
