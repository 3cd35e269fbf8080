// Energy of law M2 at each particle; see kernels/ordinary_energy.decl.
#include "kernels/ordinary_energy.h"
#include "backends/openmp/body.h"
#include "backends/openmp/rest.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void ordinary_energy(const kernels::ordinary_energy::View<real>& k) {
  if (k.gated && k.gate[0].x > 0) return; // SOLVER_STOP
  with_rest(k, [&](auto plastic) {
#pragma omp parallel for schedule(static)
    for (uint local = 0; local < k.threads; ++local) {
      const uint i = k.first + local;
      const Vec3<real> yi = xyz(k.position[i]), ui = xyz(k.displacement[i]);
      real stretching = 0, dilatation = 0;
      for_each_bond_at_rest<plastic()>(k, local, [&](uint j, Vec3<real> xi, const RestBond<real>& at_rest) {
        const Vec3<real> y = (xyz(k.position[j]) - yi) + (xyz(k.displacement[j]) - ui);
        const real x = norm(xi) * at_rest.p_out, stretch = norm(y) - x;
        stretching += at_rest.c_out * stretch * stretch;
        dilatation += at_rest.c_out * x * stretch;
      });
      const real inverse_modulus = k.shape[i];
      dilatation *= inverse_modulus; // theta - 1
      const real coupling = k.shape[k.stride + i];
      const real volumetric = inverse_modulus > 0 ? coupling * dilatation * dilatation / inverse_modulus : 0;
      k.energy[i] = (stretching + volumetric) / 2;
    }
  });
}

PLIANT_BODY(ordinary_energy)

} // namespace pliant::openmp::PLIANT_ISA
