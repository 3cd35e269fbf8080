// A vertex follows the particles nearest to it; see kernels/skin.decl.
#include "kernels/skin.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void skin(const kernels::skin::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint v = 0; v < k.threads; ++v) {
    const uint nearest[] = {k.skin_particle[v].x, k.skin_particle[v].y, k.skin_particle[v].z,
                            k.skin_particle[v].w};
    const real w[] = {k.skin_weight[v].x, k.skin_weight[v].y, k.skin_weight[v].z, k.skin_weight[v].w};
    Vec3<real> x{0, 0, 0};
    real field = 0;
    for (int c = 0; c < 4; ++c) {
      const uint j = nearest[c];
      const Vec3<real> off = xyz(k.skin_reference[v]) - xyz(k.reference[j]);
      const Vec3<real> moved{dot(xyz(k.gradient[3 * j]), off), dot(xyz(k.gradient[3 * j + 1]), off),
                             dot(xyz(k.gradient[3 * j + 2]), off)};
      x = x + w[c] * (xyz(k.particle[j]) + moved);
      field += w[c] * k.particle[j].w;
    }
    k.vertex[v] = {x.x, x.y, x.z, field};
  }
}

PLIANT_BODY(skin)

} // namespace pliant::openmp::PLIANT_ISA
