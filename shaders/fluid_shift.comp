// Shifts that multipliers make; see kernels/fluid_shift.decl.
#include "common/fluid.glsl"
#include "common/near.glsl"
#include "common/smoothing.glsl"

void main() {
  uint i = thread_index();
  if (i >= threads) return;
  vec4 place = fluid_place[i];
  vec3 period = vec3(period_x, period_y, period_z), own = vec3(0.0), theirs = vec3(0.0);
  uint slice = i / 16u, first = 16u * rows * slice + i % 16u, count = near_count[slice];
  for (uint r = 0u; r < count; ++r) {
    uint j = near[first + 16u * r];
    if (j == i) break;
    vec4 other = fluid_place[j];
    vec3 d = shortest(place.xyz - other.xyz, period);
    vec3 slope = spline_slope(min(length(d) / support, 1.0)) * d;
    own += abs(other.w) * slope;
    theirs += fluid_lambda[j] * slope;
  }
#if walls
  own += fluid_material[FLUID_ROWS * uint(fluid_velocity[i].w) + FLUID_TRAITS].x / slope_scale * fluid_wall[i].xyz;
#endif
  vec3 shift = place.w > 0.0 ? slope_scale * (fluid_lambda[i] / place.w * own + theirs) : vec3(0.0);
  fluid_shift[i] = vec4(place.xyz + shift, place.w);
}
