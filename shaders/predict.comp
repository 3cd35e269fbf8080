// predict: the inertia target y* of Eq. 12, relative to the position at the start of the step, and the first
// guess of the displacement.
//
// Implicit Euler:  u* = h v + h^2 (g + f/m)
// BDF2:            u* = (ybar - y) + hbar vbar + hbar^2 (g + f/m), with hbar = (2/3) h the parameter `step`,
//                  ybar - y = (4 y^n - y^(n-1))/3 - y^n = (y^n - y^(n-1))/3, vbar = (4 v^n - v^(n-1))/3.
// The guess takes back the share of gravity that the last step did not give: a particle at rest starts at rest,
// one in free flight starts at its target.
void main() {
  uint i = thread_index();
  if (i >= min(threads, particle_count)) return;
  real mass = external_force[i].w;
  if (mass <= 0.0) { // held: another kernel moves it
    inertia_target[i] = real4(0.0);
    displacement[i] = real4(0.0);
    earlier_iterate[i] = real4(0.0);
    return;
  }
  real4 v = velocity[i];
  vec3 gravity = vec3(gravity_x, gravity_y, gravity_z);
  vec3 acceleration = gravity + external_force[i].xyz / mass;
#if bdf2
  vec3 start = earlier_shift[i].xyz / 3.0;
  vec3 drift = (4.0 * v.xyz - earlier_velocity[i].xyz) / 3.0;
  vec3 target = start + step * drift + step * step * acceleration;
#else
  vec3 target = step * v.xyz + step * step * acceleration;
#endif
  vec3 guess = target - (1.0 - v.w) * step * step * gravity;
  inertia_target[i] = real4(target, mass / (step * step));
  displacement[i] = real4(guess, 0.0);
  earlier_iterate[i] = real4(guess, 0.0);
}
