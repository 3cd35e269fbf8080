// Derivative of the contact forces; see kernels/contact_product.decl.
#include "kernels/contact_product.h"
#include "backends/openmp/body.h"
#include "backends/openmp/pairs.h"
#include "shaders/common/contact.glsl"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void contact_product(const kernels::contact_product::View<real>& k) {
  if (k.solver[SOLVER_LINEAR] == 0) return;
  const real d2 = k.contact_distance * k.contact_distance;
#pragma omp parallel for schedule(static)
  for (uint i = 0; i < k.threads; ++i) {
    const uint* list = k.contact + std::size_t{CONTACTS * 16} * (i / 16) + i % 16;
    const auto here = k.start[i];
    const Vec3<real> u = xyz(k.displacement[i]), p = xyz(k.direction[i]);
    Vec3<real> rate{0, 0, 0};
    for (uint a = 0; a < CONTACTS; ++a) {
      const uint j = list[16 * a];
      if (j == i) break;
      if (j & CONTACT_DROPPED) continue;
      const auto there = k.start[j];
      const Vec3<real> moved = xyz(k.displacement[j]) - u, relative = xyz(k.direction[j]) - p;
      const Vec3<real> y = (xyz(there) - xyz(here)) + moved;
      const real r2 = dot(y, y);
      if (!(r2 < d2)) continue;
      const real r = root(r2), both = smaller(here.w, there.w) / 2;
      const Vec3<real> n = r2 > real(1e-12) * d2 ? (1 / r) * y : agreed_direction<real>(i, j);
      const real limit = k.friction * both * (k.contact_distance - r);
      const Vec3<real> slide = moved - dot(n, moved) * n;
      const real slid = norm(slide), hold = both * slid < limit ? both
                                            : slid > 0          ? limit / slid
                                                                : 0; // no friction: none
      rate = rate + hold * relative + ((both - hold) * dot(n, relative)) * n;
    }
    const auto f = k.force[i];
    k.force[i] = {f.x + rate.x, f.y + rate.y, f.z + rate.z, f.w};
  }
}

PLIANT_BODY(contact_product)

} // namespace pliant::openmp::PLIANT_ISA
