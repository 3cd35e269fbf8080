// The inertia target and the first guess; see kernels/predict.decl.
//
// Implicit Euler:  u* = h v + h^2 (g + f/m)
// BDF2:            u* = (ybar - y) + hbar vbar + hbar^2 (g + f/m), with hbar = (2/3) h the parameter time_step,
//                  ybar - y = (4 y^n - y^(n-1))/3 - y^n = (y^n - y^(n-1))/3, vbar = (4 v^n - v^(n-1))/3.
// The guess takes back the share of gravity that the last step did not give: a particle at rest starts at rest,
// one in free flight starts at its target.
void main() {
  uint i = thread_index();
  if (i >= threads) return;
  float mass = position[i].w;
  vec4 v = velocity[i];
  vec3 gravity = vec3(gravity_x, gravity_y, gravity_z), acceleration = gravity;
#if loaded
  acceleration += external_force[i].xyz / mass;
#endif
  float h2 = time_step * time_step;
#if bdf2
  vec3 target = earlier_shift[i].xyz / 3.0 + time_step * (4.0 * v.xyz - earlier_velocity[i].xyz) / 3.0 +
                h2 * acceleration;
#else
  vec3 target = time_step * v.xyz + h2 * acceleration;
#endif
  vec3 guess = target - (1.0 - v.w) * h2 * gravity;
  inertia_target[i] = vec4(target, mass / h2);
  displacement[i] = vec4(guess, 0.0);
}
