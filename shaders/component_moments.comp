// What is left of momentum in each chunk; see kernels/component_moments.decl.
#include "common/group_sum.glsl"

void main() {
  uint group = group_index(), lane = gl_LocalInvocationIndex;
  if (group >= threads / 128) return; // the whole group: no barrier is missed
  uint first = chunk[group].x, end = chunk[group].y;
  vec4 drift = vec4(0.0), centre = vec4(0.0), spin = vec4(0.0), square = vec4(0.0), mixed = vec4(0.0);
  for (uint i = first + lane; i < end; i += 128) {
    vec4 p = position[i], target = inertia_target[i];
    float m = p.w;
    vec3 u = displacement[i].xyz, d = u - target.xyz, y = p.xyz + u;
    bool free = target.w >= 0.0;
#if contacts
    free = free && touched[i] == 0;
#endif
    drift += m * vec4(d, 1.0);
    centre += vec4(m * y, free ? 0.0 : 1.0);
    spin.xyz += m * cross(y, d);
    square.xyz += m * y * y;
    mixed.xyz += m * vec3(y.x * y.y, y.x * y.z, y.y * y.z);
  }
  drift = sum_over_group(drift);
  centre = sum_over_group(centre);
  spin = sum_over_group(spin);
  square = sum_over_group(square);
  mixed = sum_over_group(mixed);
  if (lane != 0) return;
  moment[5 * group] = drift;
  moment[5 * group + 1] = centre;
  moment[5 * group + 2] = spin;
  moment[5 * group + 3] = square;
  moment[5 * group + 4] = mixed;
}
