// Rates and the first residual; see kernels/fluid_viscosity_begin.decl.
#include "common/fluid.glsl"
#include "common/group_sum.glsl"
#include "common/near.glsl"
#include "common/smoothing.glsl"

// Of the support: particles nearer to each other are held to be as far, whatever the direction.
const float LEAST_ARM = 1e-3;

float viscosity_of(float material) { return fluid_material[FLUID_ROWS * uint(material) + FLUID_TRAITS].y; }

void main() {
  uint i = thread_index();
  float energy = 0.0;
  if (i < threads) {
    vec4 place = fluid_place[i], v = fluid_velocity[i];
    vec3 period = vec3(period_x, period_y, period_z), change = vec3(0.0);
    uint slice = i / 16u, first = 16u * rows * slice + i % 16u, count = near_count[slice];
    bool moves = place.w > 0.0;
    float mu = moves ? viscosity_of(v.w) : 0.0;
#if ghosts
    vec3 away = vec3(0.0); // from the walls
    for (uint r = 0u; r < count && moves; ++r) {
      uint j = near[first + 16u * r];
      vec4 other = fluid_place[j];
      vec3 d = shortest(place.xyz - other.xyz, period);
      if (other.w < 0.0) away += viscous_laplacian(length(d) / support) * d;
    }
    float far = length(away);
    if (far > 0.0) away /= far;
#endif
    for (uint r = 0u; r < count; ++r) {
      uint j = near[first + 16u * r];
      vec4 other = fluid_place[j], w = fluid_velocity[j];
      vec3 d = shortest(place.xyz - other.xyz, period);
      float rate = 0.0;
      if (j != i && moves) {
        float both = mu;
#if mixed
        float theirs = other.w > 0.0 ? viscosity_of(w.w) : mu;
        both = mu + theirs > 0.0 ? 2.0 * mu * theirs / (mu + theirs) : 0.0;
#endif
        rate = coupling * both * viscous_laplacian(length(d) / support) / place.w;
#if ghosts
        if (other.w < 0.0) {
          float depth = max(-w.w, 0.0), reach = max(dot(d, away) - depth, least_distance);
          rate *= (reach + depth) / reach;
        }
#endif
      }
#if central
      vec3 arm = shortest(fluid_start[i].xyz - fluid_start[j].xyz, period);
      float least = LEAST_ARM * support;
      rate /= max(dot(arm, arm), least * least);
      change += rate * dot(arm, w.xyz - v.xyz) * arm;
#else
      change += rate * (w.xyz - v.xyz);
#endif
      near_rate[first + 16u * r] = rate;
    }
    fluid_residual[i] = vec4(change, max(place.w, 0.0));
    if (moves) energy = place.w * dot(v.xyz, v.xyz);
  }
  vec4 sum = sum_over_group(vec4(energy, 0.0, 0.0, 0.0));
  if (local_index() == 0u) fluid_partial[group_index()] = sum;
}
