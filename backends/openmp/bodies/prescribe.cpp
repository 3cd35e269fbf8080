// Held particles go where their motion takes them; see kernels/prescribe.decl.
#include "kernels/prescribe.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void prescribe(const kernels::prescribe::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint entry = 0; entry < k.threads; ++entry) {
    const uint i = k.held[2 * entry], m = k.held[2 * entry + 1];
    const Vec3<real> x0 = xyz(k.held_start[entry]);
    const auto &r0 = k.motion[3 * m], &r1 = k.motion[3 * m + 1], &r2 = k.motion[3 * m + 2];
    const Vec3<real> x{dot(xyz(r0), x0) + r0.w, dot(xyz(r1), x0) + r1.w, dot(xyz(r2), x0) + r2.w};
    const Vec3<real> u = (x - xyz(k.origin[k.owner[i]])) - xyz(k.position[i]);
    k.inertia_target[i] = {u.x, u.y, u.z, -1};
    k.displacement[i] = {u.x, u.y, u.z, 0};
  }
}

PLIANT_BODY(prescribe)

} // namespace pliant::openmp::PLIANT_ISA
