// What the density constraint starts with; see kernels/fluid_warm.decl.

void main() {
  uint i = thread_index();
  if (i >= threads) return;
  fluid_total[i] = share * min(fluid_start[i].w, 0.0);
  fluid_moved[i] = vec4(time_step * fluid_velocity[i].xyz, 0.0);
}
