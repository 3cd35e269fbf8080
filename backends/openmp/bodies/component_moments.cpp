// What is left of momentum in each chunk; see kernels/component_moments.decl.
#include "kernels/component_moments.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void component_moments(const kernels::component_moments::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint group = 0; group < k.threads / kernels::component_moments::group_size; ++group) {
    const uint first = k.chunk[group].x, end = k.chunk[group].y;
    Vec3<real> drift{0, 0, 0}, centre{0, 0, 0}, spin{0, 0, 0}, square{0, 0, 0}, mixed{0, 0, 0};
    real mass = 0, held = 0;
    for (uint i = first; i < end; ++i) {
      const real m = k.position[i].w;
      const Vec3<real> u = xyz(k.displacement[i]), d = u - xyz(k.inertia_target[i]),
                       y = xyz(k.position[i]) + u;
      if (k.inertia_target[i].w < 0 || (k.contacts && k.touched[i])) held += 1;
      mass += m;
      drift = drift + m * d;
      centre = centre + m * y;
      spin = spin + m * cross(y, d);
      square = square + m * Vec3<real>{y.x * y.x, y.y * y.y, y.z * y.z};
      mixed = mixed + m * Vec3<real>{y.x * y.y, y.x * y.z, y.y * y.z};
    }
    k.moment[5 * group] = {drift.x, drift.y, drift.z, mass};
    k.moment[5 * group + 1] = {centre.x, centre.y, centre.z, held};
    k.moment[5 * group + 2] = {spin.x, spin.y, spin.z, 0};
    k.moment[5 * group + 3] = {square.x, square.y, square.z, 0};
    k.moment[5 * group + 4] = {mixed.x, mixed.y, mixed.z, 0};
  }
}

PLIANT_BODY(component_moments)

} // namespace pliant::openmp::PLIANT_ISA
