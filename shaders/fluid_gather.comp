// Particles of a fluid in sorted order; see kernels/fluid_gather.decl.
#include "common/fluid.glsl"

void main() {
  uint place = thread_index();
  if (place >= threads) return;
  vec4 y = vec4(0.0), at = vec4(1e15, 1e15, 1e15, 0.0), v = vec4(0.0);
  uint i = place < particle_count + ghost_count ? fluid_particle[place] : particle_count;
  if (i < particle_count) {
    uint kind = fluid_kind[i];
    vec4 old = position[i], before = velocity[i];
    y = vec4((origin[kind & FLUID_BODY].xyz - vec3(base_x, base_y, base_z)) + old.xyz, before.w);
    bool held = before.w > FLUID_HELD * time_step;
    v = vec4(before.xyz, float(kind >> FLUID_KIND_SHIFT));
    if (!held) v.xyz += time_step * vec3(gravity_x, gravity_y, gravity_z);
    if (old.w != 0.0) at = vec4(y.xyz + time_step * v.xyz, held ? -old.w : old.w);
  }
  fluid_place[place] = at;
  fluid_velocity[place] = v;
  fluid_start[place] = y;
}
