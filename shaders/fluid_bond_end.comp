// See kernels/fluid_bond_end.decl.
void main() {
  uint i = thread_index();
  if (i >= threads || !(fluid_place[i].w > 0.0)) return;
  vec3 u = fluid_best[i].xyz;
  fluid_velocity[i].xyz = u / time_step;
  fluid_place[i].xyz = fluid_start[i].xyz + u;
}
