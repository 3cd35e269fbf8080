// Moves each particle with its component; see kernels/component_apply.decl.

void main() {
  uint group = group_index(), lane = gl_LocalInvocationIndex;
  if (group >= threads / 128) return;
  uint first = chunk[group].x, end = chunk[group].y, c = chunk[group].z;
  vec3 shift = rigid[3 * c].xyz, w = rigid[3 * c + 1].xyz, centre = rigid[3 * c + 2].xyz;
  // Rodrigues, in a form that is exact and smooth for small angles: x + 2 q x (q x x + q_w x), q = (w / 2, 1) / |.|.
  vec4 q = normalize(vec4(0.5 * w, 1.0));
  for (uint i = first + lane; i < end; i += 128) {
    vec3 u = displacement[i].xyz, x = (position[i].xyz - centre) + u;
    displacement[i].xyz = u + shift + 2.0 * cross(q.xyz, cross(q.xyz, x) + q.w * x);
  }
}
