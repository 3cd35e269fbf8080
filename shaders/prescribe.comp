// Held particles go where their motion takes them; see kernels/prescribe.decl.

void main() {
  uint k = thread_index();
  if (k >= threads) return;
  uint i = held[2 * k], m = held[2 * k + 1];
  vec4 x0 = vec4(held_start[k].xyz, 1.0);
  vec3 x = vec3(dot(motion[3 * m], x0), dot(motion[3 * m + 1], x0), dot(motion[3 * m + 2], x0));
  vec3 u = (x - origin[owner[i]].xyz) - position[i].xyz;
  inertia_target[i] = vec4(u, -1.0);
  displacement[i] = vec4(u, 0.0);
}
