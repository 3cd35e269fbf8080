// What contacts read of a particle; see kernels/contact_start.decl.
#include "kernels/contact_start.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void contact_start(const kernels::contact_start::View<real>& k) {
  const Vec3<real> base{k.base_x, k.base_y, k.base_z};
#pragma omp parallel for schedule(static)
  for (uint i = 0; i < k.threads; ++i) {
    const Vec3<real> y = (xyz(k.origin[k.owner[i]]) - base) + xyz(k.position[i]);
    const real stiffness = k.linear_start[i].w;
    k.start[i] = {y.x, y.y, y.z, stiffness > 0 ? stiffness : k.least_stiffness};
  }
}

PLIANT_BODY(contact_start)

} // namespace pliant::openmp::PLIANT_ISA
