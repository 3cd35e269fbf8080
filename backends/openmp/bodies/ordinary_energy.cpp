// Energy of law M2 at each particle; see kernels/ordinary_energy.decl.
#include "kernels/ordinary_energy.h"
#include "backends/openmp/body.h"
#include "backends/openmp/slice.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void ordinary_energy(const kernels::ordinary_energy::View<real>& k) {
  if (k.gated && k.gate[0].x > 0) return; // SOLVER_STOP
#pragma omp parallel for schedule(static)
  for (uint local = 0; local < k.threads; ++local) {
    const uint i = k.first + local;
    const Vec3<real> yi = xyz(k.position[i]), ui = xyz(k.displacement[i]);
    real stretching = 0, dilatation = 0;
    for_each_bond(k, local, [&](uint j, Vec3<real> xi, real c_out, real) {
      const Vec3<real> y = (xyz(k.position[j]) - yi) + (xyz(k.displacement[j]) - ui);
      const real x = norm(xi), stretch = norm(y) - x;
      stretching += c_out * stretch * stretch;
      dilatation += c_out * x * stretch;
    });
    const real inverse_modulus = k.shape[i];
    dilatation *= inverse_modulus; // theta - 1
    const real coupling = k.shape[k.stride + i];
    const real volumetric = inverse_modulus > 0 ? coupling * dilatation * dilatation / inverse_modulus : 0;
    k.energy[i] = (stretching + volumetric) / 2;
  }
}

PLIANT_BODY(ordinary_energy)

} // namespace pliant::openmp::PLIANT_ISA
