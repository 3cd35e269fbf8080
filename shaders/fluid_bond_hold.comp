// Redistribution of what flows only; see kernels/fluid_bond_hold.decl.

void main() {
  uint i = thread_index();
  if (i >= threads || !(fluid_stay[i].z > 0.0)) return;
#if plastic
  float most = rate * fluid_flow[2u * i + 1u].w;
#else
  float most = 0.0;
#endif
  vec3 before = fluid_before[i].xyz, shift = fluid_place[i].xyz - before;
  float size = length(shift);
  if (size > most) fluid_place[i].xyz = before + (most / size) * shift;
}
