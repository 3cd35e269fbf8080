// Energy of law M3 at each particle; see kernels/stretch_energy.decl.
#include "kernels/stretch_energy.h"
#include "backends/openmp/basis.h"
#include "backends/openmp/body.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void stretch_energy(const kernels::stretch_energy::View<real>& k) {
  if (k.gated && k.gate[0].x > 0) return; // SOLVER_STOP
#pragma omp parallel for schedule(static)
  for (uint local = 0; local < k.threads; ++local) {
    const uint i = k.first + local, row0 = static_cast<uint>(k.shape[2 * std::size_t{k.stride} + i]);
    const bool squared = k.energies[row0].x > 0;
    const Vec3<real> yi = xyz(k.position[i]), ui = xyz(k.displacement[i]);
    real stretching = 0, lengthening = 0;
    for_each_bond_of_strength(k, local, [&](uint j, Vec3<real> xi, real c_out, real, real g_out, real) {
      const Vec3<real> y = (xyz(k.position[j]) - yi) + (xyz(k.displacement[j]) - ui);
      const real x = norm(xi), per_x = x > 0 ? 1 / x : 0, size = norm(y);
      const real h = g_out * basis_value(k.energies + row0 + STRETCH_BOND, (size - x) * per_x);
      stretching += c_out * x * x * h;
      lengthening += c_out * lengthening_of(size, x, squared);
    });
    const real inverse_modulus = k.shape[i], e = dilatation_of(inverse_modulus * lengthening, squared);
    const real volumetric =
        inverse_modulus > 0 ? basis_value(k.energies + row0 + STRETCH_VOLUME, e) / inverse_modulus : 0;
    k.energy[i] = (stretching + volumetric) / 2;
  }
}

PLIANT_BODY(stretch_energy)

} // namespace pliant::openmp::PLIANT_ISA
