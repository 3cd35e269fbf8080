// What contacts read of a particle; see kernels/contact_start.decl.

void main() {
  uint i = thread_index();
  if (i >= threads) return;
  vec3 y = (origin[owner[i]].xyz - vec3(base_x, base_y, base_z)) + position[i].xyz;
  float stiffness = linear_start[i].w;
  start[i] = vec4(y, stiffness > 0.0 ? stiffness : least_stiffness);
}
