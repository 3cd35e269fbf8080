// Moves each particle with its component; see kernels/component_apply.decl.
#include "kernels/component_apply.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void component_apply(const kernels::component_apply::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint group = 0; group < k.threads / kernels::component_apply::group_size; ++group) {
    const uint first = k.chunk[group].x, end = k.chunk[group].y, c = k.chunk[group].z;
    const Vec3<real> shift = xyz(k.rigid[3 * c]), w = xyz(k.rigid[3 * c + 1]),
                     centre = xyz(k.rigid[3 * c + 2]);
    // Rodrigues, in a form that is exact and smooth for small angles.
    const real scale = 1 / root(1 + dot(w, w) / 4);
    const Vec3<real> q = (scale / 2) * w;
    for (uint i = first; i < end; ++i) {
      const Vec3<real> u = xyz(k.displacement[i]), x = (xyz(k.position[i]) - centre) + u;
      const Vec3<real> turned = u + shift + real(2) * cross(q, cross(q, x) + scale * x);
      k.displacement[i] = {turned.x, turned.y, turned.z, 0};
    }
  }
}

PLIANT_BODY(component_apply)

} // namespace pliant::openmp::PLIANT_ISA
