// Forces between touching particles; see kernels/contact_force.decl.
#include "common/bonds.glsl"
#include "common/contact.glsl"
#include "common/pairs.glsl"
#include "common/solver.glsl"

void main() {
  uint i = thread_index();
  if (i >= threads || solver[SOLVER_STOP] > 0.0) return;
  vec4 here = start[i];
  vec3 u = displacement[i].xyz, push = vec3(0.0);
  float stiffness = 0.0, stored = 0.0;
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
    stored += 0.25 * k * (contact_distance - r) * (contact_distance - r); // the other half is the partner's
  }
  uint acts = stiffness > 0.0 ? 1u : 0u;
  if (acts != 0u) force[i] += vec4(push, stiffness);
#if potential
  if (acts != 0u) energy[i] += stored;
#endif
#if alone
  touched[i] = acts;
#else
  touched[i] |= acts;
#endif
}
