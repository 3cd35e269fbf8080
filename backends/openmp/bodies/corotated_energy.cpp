// Energy of law M4 at each particle; see kernels/corotated_energy.decl.
#include "kernels/corotated_energy.h"
#include "backends/openmp/body.h"
#include "backends/openmp/slice.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void corotated_energy(const kernels::corotated_energy::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint local = 0; local < k.threads; ++local) {
    const uint i = k.first + local;
    const Vec3<real> yi = xyz(k.position[i]), ui = xyz(k.displacement[i]);
    const Mat3<real> r = rotation_matrix(k.rotation[i]);
    real deviation = 0, dilatation = 0;
    for_each_bond(k, local, [&](uint j, Vec3<real> xi, real c_out, real) {
      const Vec3<real> y = (xyz(k.position[j]) - yi) + (xyz(k.displacement[j]) - ui), target = r * xi;
      const Vec3<real> off = y - target;
      deviation += c_out * dot(off, off);
      dilatation += c_out * dot(off, target);
    });
    const real inverse_modulus = k.shape[i];
    dilatation *= inverse_modulus; // theta - 1
    const real coupling = k.shape[k.stride + i];
    const real volumetric = inverse_modulus > 0 ? coupling * dilatation * dilatation / inverse_modulus : 0;
    k.energy[i] = (deviation + volumetric) / 2;
  }
}

PLIANT_BODY(corotated_energy)

} // namespace pliant::openmp::PLIANT_ISA
