// Redistribution of what flows only; see kernels/fluid_bond_hold.decl.

void main() {
  uint i = thread_index();
  if (i >= threads || !(fluid_stay[i].z > 0.0)) return;
  vec3 before = fluid_before[i].xyz;
#if plastic
  vec4 stays = fluid_flow[2u * i + 1u];
  float share = min(10.0 * (1.0 - min(stays.y, stays.z)), 1.0);
#else
  float share = 0.0;
#endif
  if (share < 1.0) fluid_place[i].xyz = before + share * (fluid_place[i].xyz - before);
}
