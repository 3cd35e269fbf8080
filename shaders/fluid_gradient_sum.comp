// One row for the step; see kernels/fluid_gradient_sum.decl.
#include "common/fluid_viscosity.glsl"
#include "common/group_sum.glsl"

void main() {
  uint lane = gl_LocalInvocationIndex;
  vec4 sum = vec4(0.0);
#if spread
  for (uint i = lane; i < place_count; i += 128) {
    vec3 g = support * fluid_gradient[i].xyz;
    float mark = fluid_normal[i].w;
    if (mark < 0.0) sum.z += 1.0;
    else if (mark <= 1.0) sum.xy += vec2(1.0, dot(g, g));
  }
#endif
  sum = sum_over_group(sum);
  if (lane != 0) return;
  spread_row[8 * row] = sum.x;
  spread_row[8 * row + 1] = sum.y;
  spread_row[8 * row + 2] = sum.z;
#if viscous
  float first = fluid_viscosity[VISCOSITY_FIRST];
  spread_row[8 * row + 3] = fluid_viscosity[VISCOSITY_ITERATIONS];
  spread_row[8 * row + 4] = first > 0.0 ? sqrt(fluid_viscosity[VISCOSITY_LEFT] / first) : 0.0;
#endif
}
