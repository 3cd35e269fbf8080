// Energy of law M2 at each particle; see kernels/ordinary_energy.decl.
#include "kernels/ordinary_energy.h"
#include "backends/openmp/body.h"
#include "backends/openmp/rest.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void ordinary_energy(const kernels::ordinary_energy::View<real>& k) {
  if (k.gated && k.gate[0].x > 0) return; // SOLVER_STOP
  const real unit = grid_unit(k.unit);
  with_rest(k, [&](auto plastic) {
#pragma omp parallel for schedule(static)
    for (uint s = 0; s < slice_count(k.threads); ++s)
      for_each_part(k, s, [&](const Part<real>& part, uint local) {
        const Wide4<real> yi = gather(k.position, part.index), ui = gather(k.displacement, part.index);
        Wide<real> stretching{}, dilatation{};
        for_each_bond_at_rest_of_part<plastic()>(
            k, local, [&](const uint* j, const Wide3<real>& xi, const WideRestBond<real>& at_rest) {
              const Wide4<real> yj = gather(k.position, j), uj = gather(k.displacement, j);
              const Wide3<real> y{(yj.x - yi.x) + (uj.x - ui.x), (yj.y - yi.y) + (uj.y - ui.y),
                                  (yj.z - yi.z) + (uj.z - ui.z)};
              const Wide<real> x = unit * root_wide<real>(dot(xi, xi)) * at_rest.p_out;
              const Wide<real> stretch = root_wide<real>(dot(y, y)) - x;
              stretching += at_rest.c_out * stretch * stretch;
              dilatation += at_rest.c_out * x * stretch;
            });
        const uint i = part.first;
        const Wide<real> inverse_modulus = load_wide(k.shape + i), none{};
        dilatation *= inverse_modulus; // theta - 1
        const Wide<real> coupling = load_wide(k.shape + k.stride + i);
        const Wide<real> volumetric =
            inverse_modulus > 0 ? coupling * dilatation * dilatation / inverse_modulus : none;
        store_reals(k.energy + i, part.count, (stretching + volumetric) / 2);
      });
  });
}

PLIANT_BODY(ordinary_energy)

} // namespace pliant::openmp::PLIANT_ISA
