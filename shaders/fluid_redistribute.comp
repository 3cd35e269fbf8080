// Shifts that spread particles; see kernels/fluid_redistribute.decl.
#include "common/fluid.glsl"
#include "common/near.glsl"
#include "common/pairs.glsl"
#include "common/smoothing.glsl"
#include "common/spread.glsl"

void main() {
  uint i = thread_index();
  if (i >= threads) return;
  vec4 place = fluid_place[i];
  if (!(place.w > 0.0)) {
    fluid_shift[i] = place;
    return;
  }
  vec4 normal = fluid_normal[i];
  bool surface = normal.w < 0.0;
  float limit = abs(normal.w), marked = surface ? 1.0 : 0.0;
  vec3 mean = normal.xyz, all = vec3(0.0), close = vec3(0.0), period = vec3(period_x, period_y, period_z);
#if form > 0
  vec4 newton = fluid_newton[i];
#endif
  uint slice = i / 16u, first = 16u * rows * slice + i % 16u, count = near_count[slice];
  for (uint r = 0u; r < count; ++r) {
    uint j = near[first + 16u * r];
    if (j == i) break;
    vec4 other = fluid_place[j], there = fluid_normal[j];
    vec3 d = shortest(place.xyz - other.xyz, period);
    float far = length(d), q = far / support, share = 1.0;
#if mixed
    share = 2.0 * abs(other.w) / (place.w + abs(other.w));
#endif
    if (there.w < 0.0) {
      float weight = max(1.0 - q, 0.0);
      mean += weight * there.xyz;
      marked += weight;
    }
    float slope = slope_scale * spiky_slope(q);
#if form == 0
    vec3 push = -share * rate * min(limit, abs(there.w)) * slope * d;
    all += push;
    close += clamp((SPREAD_FAR * spacing - far) / ((SPREAD_FAR - SPREAD_NEAR) * spacing), 0.0, 1.0) * push;
#elif form == 1
    vec3 v = newton.xyz - fluid_newton[j].xyz, n = far > 0.0 ? d / far : vec3(0.0);
    all -= share * (slope * v + (curvature_scale * spiky_curvature(q) - slope) * dot(n, v) * n);
#else
    all += share * rate * 0.5 * (newton.w + fluid_newton[j].w) * slope * d;
#endif
#if tension
    if (far < SPREAD_APART * spacing) {
      vec3 n = far > 1e-6 * spacing ? d / far : -agreed_direction(i, j);
      vec3 part = share * SPREAD_APART_RATE * (SPREAD_APART * spacing - far) * n;
      all += part;
      close += part;
    }
#endif
  }
#if form == 0
  vec3 shift = marked > 0.0 ? close : all;
#else
  vec3 shift = all;
#endif
  if (marked > 0.0) {
    mean /= marked;
    float far = length(mean);
    if (far > 0.0) shift -= min(far / SURFACE_FULL, 1.0) / (far * far) * dot(mean, shift) * mean;
  }
#if tension
  shift += pull * fluid_material[FLUID_ROWS * uint(fluid_velocity[i].w) + FLUID_TRAITS].w * normal.xyz;
#endif
  fluid_shift[i] = vec4(place.xyz + shift, place.w);
}
