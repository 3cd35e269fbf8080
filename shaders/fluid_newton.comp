// Multipliers of Newton's method; see kernels/fluid_newton.decl.
#include "common/near.glsl"
#include "common/smoothing.glsl"

void main() {
  uint i = thread_index();
  if (i >= threads) return;
  vec4 place = fluid_place[i];
  vec3 g = fluid_gradient[i].xyz, period = vec3(period_x, period_y, period_z), own = vec3(0.0);
  float mark = abs(fluid_normal[i].w), squares = 0.0;
  uint slice = i / 16u, first = 16u * rows * slice + i % 16u, count = near_count[slice];
  for (uint r = 0u; r < count; ++r) {
    uint j = near[first + 16u * r];
    if (j == i) break;
    vec4 other = fluid_place[j];
    vec3 d = shortest(place.xyz - other.xyz, period);
    float far = length(d), q = far / support, slope = slope_scale * spiky_slope(q);
    vec3 n = far > 0.0 ? d / far : vec3(0.0);
    vec3 h = slope * g + (curvature_scale * spiky_curvature(q) - slope) * dot(n, g) * n;
    own += h;
    if (other.w > 0.0) squares += dot(h, h);
  }
  float size = dot(g, g), all = dot(own, own) + squares + softness * size;
  float tau = all > 0.0 && mark <= 1.0 ? size / all : 0.0;
  float share = rate * mark, alone = tau * length(own);
  if (share * alone > limit) share = limit / alone;
  tau *= share;
  fluid_newton[i] = vec4(tau * g, tau);
}
