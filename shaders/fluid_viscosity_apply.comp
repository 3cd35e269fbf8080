// See kernels/fluid_viscosity_apply.decl.
void main() {
  uint i = thread_index();
  if (i >= threads || !(fluid_place[i].w > 0.0)) return;
  fluid_place[i].xyz = fluid_start[i].xyz + time_step * fluid_velocity[i].xyz;
}
