// Forces between touching particles; see kernels/contact_force.decl.
#include "kernels/contact_force.h"
#include "backends/openmp/body.h"
#include "backends/openmp/pairs.h"
#include "backends/openmp/simd.h"
#include "shaders/common/contact.glsl"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

namespace {

template <class real> PLIANT_INLINE void touch(const kernels::contact_force::View<real>& k, uint i) {
  const real d2 = k.contact_distance * k.contact_distance;
  const uint* list = k.contact + std::size_t{CONTACTS * 16} * (i / 16) + i % 16;
  const auto here = k.start[i];
  const Vec3<real> u = xyz(k.displacement[i]);
  Vec3<real> push{0, 0, 0};
  real stiffness = 0, stored = 0;
  for (uint a = 0; a < CONTACTS; ++a) {
    const uint j = list[16 * a];
    if (j == i) break;
    if (j & CONTACT_DROPPED) continue;
    const auto there = k.start[j];
    const Vec3<real> moved = xyz(k.displacement[j]) - u;
    const Vec3<real> y = (xyz(there) - xyz(here)) + moved;
    const real r2 = dot(y, y);
    if (!(r2 < d2)) continue;
    const real r = root(r2), both = smaller(here.w, there.w) / 2;
    const Vec3<real> n = r2 > real(1e-12) * d2 ? (1 / r) * y : agreed_direction<real>(i, j);
    const real normal = both * (k.contact_distance - r), limit = k.friction * normal;
    const Vec3<real> slide = moved - dot(n, moved) * n;
    const real slid = norm(slide), hold = both * slid > limit ? limit / slid : both;
    push = push + (hold * slide - normal * n);
    stiffness += both;
    const real depth = k.contact_distance - r;
    stored += both / 4 * depth * depth; // the other half is the partner's
  }
  const uint acts = stiffness > 0;
  if (acts) {
    const auto f = k.force[i];
    k.force[i] = {f.x + push.x, f.y + push.y, f.z + push.z, f.w + stiffness};
  }
  if (k.potential && acts) k.energy[i] += stored;
  k.touched[i] = k.alone ? acts : (k.touched[i] | acts);
}

} // namespace

template <class real> void contact_force(const kernels::contact_force::View<real>& k) {
  if (k.solver[SOLVER_STOP] > 0) return;
#pragma omp parallel for schedule(static)
  for (uint first = 0; first < k.threads; first += lanes<real>) {
    // A list ends with the particle itself: most begin with it.
    const uint* const begins = k.contact + std::size_t{CONTACTS * 16} * (first / 16) + first % 16;
    const uint last = smaller(first + lanes<real>, k.threads);
    uint any = 0;
    for (uint i = first; i < last; ++i) any |= begins[i - first] ^ i;
    if (any)
      for (uint i = first; i < last; ++i) touch(k, i);
    else if (k.alone)
      for (uint i = first; i < last; ++i) k.touched[i] = 0;
  }
}

PLIANT_BODY(contact_force)

} // namespace pliant::openmp::PLIANT_ISA
