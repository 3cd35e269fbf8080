// Velocities; see kernels/fluid_speed.decl.

void main() {
  uint i = thread_index();
  if (i >= threads) return;
  if (fluid_place[i].w > 0.0) fluid_velocity[i].xyz = fluid_moved[i].xyz / time_step;
}
