// Eq. 8 of He, Wang, Wu 2017 at each particle; see kernels/projective_energy.decl.
#include "kernels/projective_energy.h"
#include "backends/openmp/body.h"
#include "backends/openmp/slice.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void projective_energy(const kernels::projective_energy::View<real>& k) {
  if (k.gated && k.gate[0].x > 0) return; // SOLVER_STOP
#pragma omp parallel for schedule(static)
  for (uint local = 0; local < k.threads; ++local) {
    const uint i = k.first + local;
    const Vec3<real> yi = xyz(k.position[i]);
    const auto i0 = k.record[3 * i], i1 = k.record[3 * i + 1], i2 = k.record[3 * i + 2];
    real sum = 0;
    for_each_bond(k, local, [&](uint j, Vec3<real> xi, real c_out, real) {
      const auto &j0 = k.record[3 * j], &j1 = k.record[3 * j + 1], &j2 = k.record[3 * j + 2];
      const Vec3<real> y = (xyz(k.position[j]) - yi) + Vec3<real>{j0.w - i0.w, j1.w - i1.w, j2.w - i2.w};
      const real x = norm(xi);
      const real affine = norm(Vec3<real>{dot(xyz(i0), xi), dot(xyz(i1), xi), dot(xyz(i2), xi)}) - x,
                 direct = norm(y) - x;
      sum += c_out * (k.deviatoric * affine * affine + (1 - k.deviatoric) * direct * direct);
    });
    k.energy[i] = sum / 2;
  }
}

PLIANT_BODY(projective_energy)

} // namespace pliant::openmp::PLIANT_ISA
