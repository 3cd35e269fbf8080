// Forces between touching particles; see kernels/contact_force.decl.
#include "common/bonds.glsl"
#include "common/contact.glsl"
#include "common/solver.glsl"

// From i to j where both are in one place: any direction will do that both agree on.
vec3 agreed_direction(uint i, uint j) {
  uint h = min(i, j) * 2654435761u ^ max(i, j) * 2246822519u;
  h ^= h >> 15;
  h *= 739982445u;
  h ^= h >> 12;
  vec3 d = vec3(float(h & 1023u), float((h >> 10) & 1023u), float((h >> 20) & 1023u)) - 511.5;
  return (i < j ? 1.0 : -1.0) * inversesqrt(dot(d, d)) * d;
}

void main() {
  uint i = thread_index();
  if (i >= threads || solver[SOLVER_STOP] > 0.0) return;
  vec4 here = start[i];
  vec3 u = displacement[i].xyz, push = vec3(0.0);
  float stiffness = 0.0;
  uint base = CONTACTS * SLICE * (i / SLICE) + i % SLICE;
  for (uint a = 0u; a < CONTACTS; ++a) {
    uint j = contact[base + SLICE * a];
    if (j == i) break;
    if ((j & CONTACT_DROPPED) != 0u) continue;
    vec4 there = start[j];
    vec3 slide = displacement[j].xyz - u;
    vec3 y = (there.xyz - here.xyz) + slide;
    float r2 = dot(y, y), d2 = contact_distance * contact_distance;
    if (!(r2 < d2)) continue;
    float r = sqrt(r2), k = 0.5 * min(here.w, there.w);
    vec3 n = r2 > 1e-12 * d2 ? y / r : agreed_direction(i, j);
    float normal = k * (contact_distance - r);
    slide -= dot(n, slide) * n;
    float slid = length(slide), hold = k * slid > friction * normal ? friction * normal / slid : k;
    push += hold * slide - normal * n;
    stiffness += k;
  }
  uint acts = stiffness > 0.0 ? 1u : 0u;
  if (acts != 0u) force[i] += vec4(push, stiffness);
#if alone
  touched[i] = acts;
#else
  touched[i] |= acts;
#endif
}
