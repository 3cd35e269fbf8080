// Derivative of the contact forces; see kernels/contact_product.decl.
#include "common/bonds.glsl"
#include "common/contact.glsl"
#include "common/pairs.glsl"
#include "common/solver.glsl"

void main() {
  uint i = thread_index();
  if (i >= threads || solver[SOLVER_LINEAR] == 0.0) return;
  vec4 here = start[i];
  vec3 u = displacement[i].xyz, p = direction[i].xyz, rate = vec3(0.0);
  uint base = CONTACTS * SLICE * (i / SLICE) + i % SLICE;
  for (uint a = 0u; a < CONTACTS; ++a) {
    uint j = contact[base + SLICE * a];
    if (j == i) break;
    if ((j & CONTACT_DROPPED) != 0u) continue;
    vec4 there = start[j];
    vec3 slide = displacement[j].xyz - u, relative = direction[j].xyz - p;
    vec3 y = (there.xyz - here.xyz) + slide;
    float r2 = dot(y, y), d2 = contact_distance * contact_distance;
    if (!(r2 < d2)) continue;
    float r = sqrt(r2), k = 0.5 * min(here.w, there.w);
    vec3 n = r2 > 1e-12 * d2 ? y / r : agreed_direction(i, j);
    float normal = k * (contact_distance - r);
    slide -= dot(n, slide) * n;
    float slid = length(slide), most = friction * normal;
    float hold = k * slid < most ? k : slid > 0.0 ? most / slid : 0.0; // no friction: none
    rate += hold * relative + ((k - hold) * dot(n, relative)) * n;
  }
  force[i].xyz += rate;
}
