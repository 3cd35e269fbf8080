// Gradients of the density and normals; see kernels/fluid_gradient.decl.
#include "common/fluid.glsl"
#include "common/near.glsl"
#include "common/smoothing.glsl"
#include "common/spread.glsl"

void main() {
  uint i = thread_index();
  if (i >= threads) return;
  vec4 place = fluid_place[i];
  if (!(place.w > 0.0)) {
    fluid_gradient[i] = vec4(0.0);
    fluid_normal[i] = vec4(0.0, 0.0, 0.0, 2.0);
    return;
  }
  vec3 period = vec3(period_x, period_y, period_z), g = vec3(0.0), normal = vec3(0.0);
  float cover = 0.0, nearest = support;
  uint slice = i / 16u, first = 16u * rows * slice + i % 16u, count = near_count[slice];
  for (uint r = 0u; r < count; ++r) {
    uint j = near[first + 16u * r];
    if (j == i) break;
    vec3 d = shortest(place.xyz - fluid_place[j].xyz, period);
    float r2 = dot(d, d), q = sqrt(r2) / support, slope = spline_slope(q);
    g += spiky_slope(q) * d;
    normal += slope * d;
    cover -= slope * r2;
    nearest = min(nearest, q * support);
  }
  g *= spiky_scale;
  normal *= normal_scale;
  vec4 traits = fluid_material[FLUID_ROWS * uint(fluid_velocity[i].w) + FLUID_TRAITS];
  float share = traits.z;
#if fickian
  float far = rate * length(g);
  if (share * far > limit) share = limit / far;
#endif
  bool surface = cover_scale * cover < SURFACE_COVER;
  fluid_gradient[i] = vec4(g, tension != 0 ? nearest : 0.0);
  fluid_normal[i] = surface ? vec4(normal / max(length(normal), 1.0), -max(share, 1e-30)) : vec4(0.0, 0.0, 0.0, share);
}
