// Shifts that multipliers make; see kernels/fluid_shift.decl.
#include "common/near.glsl"
#include "common/smoothing.glsl"

void main() {
  uint i = thread_index();
  if (i >= threads) return;
  vec3 place = fluid_lambda[i].xyz, period = vec3(period_x, period_y, period_z), theirs = vec3(0.0);
  vec4 pull = fluid_pull[i];
  uint slice = i / 16u, first = 16u * rows * slice + i % 16u, count = near_count[slice];
  for (uint r = 0u; r < count; ++r) {
    uint j = near[first + 16u * r];
    if (j == i) break;
    vec4 other = fluid_lambda[j];
    vec3 d = shortest(place - other.xyz, period);
    theirs += other.w * spline_slope(min(length(d) / support, 1.0)) * d;
  }
  if (pull.w > 0.0) {
    vec3 moved = fluid_moved[i].xyz + (pull.xyz + slope_scale * theirs);
    fluid_moved[i].xyz = moved;
    place = fluid_start[i].xyz + moved;
  }
  fluid_place[i] = vec4(place, pull.w);
}
