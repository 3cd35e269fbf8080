// Multipliers of the density constraints; see kernels/fluid_lambda.decl.
#include "common/fluid.glsl"
#include "common/near.glsl"
#include "common/smoothing.glsl"

void main() {
  uint i = thread_index();
  if (i >= threads) return;
  vec4 place = fluid_place[i];
  vec3 period = vec3(period_x, period_y, period_z);
  uint slice = i / 16u, first = 16u * rows * slice + i % 16u, count = near_count[slice];
  float sum = abs(place.w) * spline_value(0.0), squares = 0.0;
  vec3 gradient = vec3(0.0);
  for (uint r = 0u; r < count; ++r) {
    uint j = near[first + 16u * r];
    if (j == i) break;
    vec4 other = fluid_place[j];
    vec3 d = shortest(place.xyz - other.xyz, period);
    float q = min(length(d) / support, 1.0), mass = abs(other.w);
    vec3 slope = spline_slope(q) * d;
    sum += mass * spline_value(q);
    gradient += mass * slope;
    squares += max(other.w, 0.0) * dot(slope, slope);
  }
  uint row = FLUID_ROWS * uint(max(fluid_velocity[i].w, 0.0)); // a ghost has none
  vec4 limits = fluid_material[row + FLUID_LIMITS];
  float rest = fluid_material[row + FLUID_TRAITS].x, error = value_scale * sum / rest - 1.0;
#if walls
  vec4 wall = fluid_wall[i];
  error += wall.w;
  gradient += rest / slope_scale * wall.xyz;
#endif
  bool moves = place.w > 0.0;
#if measured
  vec3 steep = slope_scale * gradient;
  float steep2 = dot(steep, steep);
  fluid_measure[i] = moves ? vec4(error, steep2, steep2 <= limits.z * limits.z ? 1.0 : 0.0, 1.0) : vec4(0.0);
#else
  float change = 0.0, total = fluid_total[i];
#if warm
  if (moves) change = total;
#else
  if (moves) {
    float scale = slope_scale / rest;
    float stiffness = scale * scale * (dot(gradient, gradient) / place.w + squares) + limits.x;
    change = -relaxation * min(error, limits.y) / (stiffness * rest);
    if (momentum > 0.0) change += momentum * fluid_lambda[i].w; // not before: it may be anything
    float most = 0.0;
#if pulls
    float inside = clamp(4.0 - 4.0 * slope_scale * length(gradient) / limits.z, 0.0, 1.0);
    most = step2 * limits.w * place.w * inside * clamp(4.0 * error + 2.0, 0.0, 1.0);
#endif
    change = min(change, most - total);
  }
  fluid_total[i] = total + change;
#endif
  fluid_lambda[i] = vec4(place.xyz, change);
  fluid_pull[i] = vec4(moves ? slope_scale * change / place.w * gradient : vec3(0.0), place.w);
#endif
}
