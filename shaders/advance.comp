// End of a step; see kernels/advance.decl.

void main() {
  uint i = thread_index();
  if (i >= threads) return;
  vec3 u = displacement[i].xyz;
  vec4 v_old = velocity[i];
  vec3 shift = u; // y_(n+1) - y_bar
#if bdf2
  shift -= earlier_shift[i].xyz / 3.0;
#endif
#if history
  earlier_velocity[i] = v_old;
  earlier_shift[i] = vec4(u, 0.0);
#endif
  vec3 v = shift / time_step;
  vec3 gravity = vec3(gravity_x, gravity_y, gravity_z);
  float g2 = dot(gravity, gravity);
  float felt = g2 > 0.0 ? clamp(dot(v - v_old.xyz, gravity) / (time_step * g2), 0.0, 1.0) : 0.0;
  velocity[i] = vec4(v, felt);
  position[i].xyz += u;
}
