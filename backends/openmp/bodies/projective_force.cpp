// Forces of law M1, gathered; see kernels/projective_force.decl.
#include "kernels/projective_force.h"
#include "backends/openmp/body.h"
#include "backends/openmp/slice.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void projective_force(const kernels::projective_force::View<real>& k) {
  if (k.solver[SOLVER_STOP] > 0) return;
#pragma omp parallel for schedule(static)
  for (uint local = 0; local < k.threads; ++local) {
    const uint i = k.first + local;
    const Vec3<real> yi = xyz(k.position[i]);
    const auto i0 = k.record[3 * i], i1 = k.record[3 * i + 1], i2 = k.record[3 * i + 2];
    Vec3<real> sum{0, 0, 0};
    for_each_bond(k, local, [&](uint j, Vec3<real> xi, real c_out, real c_in) {
      const auto &j0 = k.record[3 * j], &j1 = k.record[3 * j + 1], &j2 = k.record[3 * j + 2];
      const Vec3<real> y = (xyz(k.position[j]) - yi) + Vec3<real>{j0.w - i0.w, j1.w - i1.w, j2.w - i2.w};
      const real x = norm(xi);
      const Vec3<real> from_i = bond_direction({dot(xyz(i0), xi), dot(xyz(i1), xi), dot(xyz(i2), xi)}, xi);
      const Vec3<real> from_j = bond_direction({dot(xyz(j0), xi), dot(xyz(j1), xi), dot(xyz(j2), xi)}, xi);
      const Vec3<real> direct = (1 - k.deviatoric) * bond_direction(y, from_i + from_j);
      sum = sum + c_out * (y - x * (k.deviatoric * from_i + direct)) +
            c_in * (y - x * (k.deviatoric * from_j + direct));
    });
    k.force[i] = {sum.x, sum.y, sum.z, k.linear_start[i].w};
  }
}

PLIANT_BODY(projective_force)

} // namespace pliant::openmp::PLIANT_ISA
