// Velocities; see kernels/fluid_speed.decl.

void main() {
  uint i = thread_index();
  if (i >= threads) return;
  vec4 place = fluid_place[i];
  if (place.w > 0.0) fluid_velocity[i].xyz = (place.xyz - fluid_start[i].xyz) / time_step;
}
