// End of a step of a fluid; see kernels/fluid_finish.decl.
#include "common/fluid.glsl"

#if bounded
bool outside(float at, float low, float high, float period) { return period == 0.0 && !(at >= low && at <= high); }
float inside(float at, float low, float period) { return period > 0.0 ? at - period * floor((at - low) / period) : at; }
#endif

void main() {
  uint k = thread_index();
  if (k >= threads) return;
  vec4 place = fluid_place[k];
  uint i = fluid_particle[k];
  if (i >= particle_count || place.w == 0.0) return; // a ghost, or removed before
  vec4 v = vec4(fluid_velocity[k].xyz, 0.0);
  if (place.w > 0.0) v.w = min(fluid_total[k], 0.0) / (time_step * time_step);
  else v.w = max(velocity[i].w - time_step, 0.0);
  place.w = abs(place.w);
#if bounded
  bool lost = outside(place.x, low_x, high_x, period_x) || outside(place.y, low_y, high_y, period_y) ||
              outside(place.z, low_z, high_z, period_z);
  bool finite = !any(isnan(place.xyz)) && !any(isinf(place.xyz)); // what is not is another fault
  if (lost && finite) {
    place.w = 0.0;
    v = vec4(0.0);
  }
  place.xyz = vec3(inside(place.x, low_x, period_x), inside(place.y, low_y, period_y), inside(place.z, low_z, period_z));
#endif
  vec3 body = origin[fluid_kind[i] & FLUID_BODY].xyz - vec3(base_x, base_y, base_z);
  position[i] = vec4(place.xyz - body, place.w);
  velocity[i] = v;
}
