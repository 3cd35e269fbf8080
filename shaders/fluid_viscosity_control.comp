// The numbers of conjugate gradients; see kernels/fluid_viscosity_control.decl.
#include "common/fluid_viscosity.glsl"

shared vec4 group_sum[256];

void main() {
  uint lane = gl_LocalInvocationIndex;
  vec4 sums = vec4(0.0);
  for (uint p = lane; p < partial_count; p += 256) sums += fluid_partial[p];
  group_sum[lane] = sums;
  barrier();
  for (uint half_width = 128; half_width > 0; half_width /= 2) {
    if (lane < half_width) group_sum[lane] += group_sum[lane + half_width];
    barrier();
  }
  if (lane != 0) return;
  sums = group_sum[0];
#if start
  fluid_viscosity[VISCOSITY_STOP] = 0.0;
  fluid_viscosity[VISCOSITY_ITERATIONS] = 0.0;
  fluid_viscosity[VISCOSITY_FIRST] = 0.0;
  fluid_viscosity[VISCOSITY_LEFT] = 0.0;
  fluid_viscosity[VISCOSITY_SPEED] = sums.x;
  fluid_viscosity[VISCOSITY_STEP] = 0.0;
  fluid_viscosity[VISCOSITY_KEEP] = 0.0;
#else
  if (fluid_viscosity[VISCOSITY_STOP] > 0.0) return;
  float squares = sums.x, product = sums.y, iteration = fluid_viscosity[VISCOSITY_ITERATIONS];
  bool first = iteration == 0.0;
  float before = fluid_viscosity[VISCOSITY_LEFT];
  if (first) fluid_viscosity[VISCOSITY_FIRST] = squares;
  fluid_viscosity[VISCOSITY_LEFT] = squares;
  float enough = max(tolerance * tolerance * fluid_viscosity[VISCOSITY_FIRST], rounding * rounding * fluid_viscosity[VISCOSITY_SPEED]);
  float keep = first ? 0.0 : squares / before;
  float curvature = first ? product : product - keep * squares / fluid_viscosity[VISCOSITY_STEP];
  if (!(squares > enough) || iteration >= float(cap) || !(curvature > 0.0) || isinf(curvature)) {
    fluid_viscosity[VISCOSITY_STOP] = 1.0;
    return;
  }
  fluid_viscosity[VISCOSITY_KEEP] = keep;
  fluid_viscosity[VISCOSITY_STEP] = squares / curvature;
  fluid_viscosity[VISCOSITY_ITERATIONS] = iteration + 1.0;
#endif
}
