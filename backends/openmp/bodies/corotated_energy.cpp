// Energy of law M4 at each particle; see kernels/corotated_energy.decl.
#include "kernels/corotated_energy.h"
#include "backends/openmp/body.h"
#include "backends/openmp/simd_rotation.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void corotated_energy(const kernels::corotated_energy::View<real>& k) {
  if (k.gated && k.gate[0].x > 0) return; // SOLVER_STOP
  const real unit = grid_unit(k.unit);
#pragma omp parallel for schedule(static)
  for (uint slice = 0; slice < slice_count(k.threads); ++slice)
    for_each_part(k, slice, [&](const Part<real>& part, uint local) {
      const uint i = part.first;
      const Wide4<real> yi = gather(k.position, part.index), ui = gather(k.displacement, part.index);
      const WideMat3<real> r = rotation_matrix<real>(gather(k.rotation, part.index));
      Wide<real> deviation{}, dilatation{};
      for_each_bond_of_part(k, local, [&](const uint* j, Wide3<real> xi, Wide<real> c_out, Wide<real>) {
        const Wide4<real> yj = gather(k.position, j), uj = gather(k.displacement, j);
        const Wide3<real> target = r * Wide3<real>{unit * xi.x, unit * xi.y, unit * xi.z};
        const Wide3<real> off{(yj.x - yi.x) + (uj.x - ui.x) - target.x,
                              (yj.y - yi.y) + (uj.y - ui.y) - target.y,
                              (yj.z - yi.z) + (uj.z - ui.z) - target.z};
        deviation += c_out * dot(off, off);
        dilatation += c_out * dot(off, target);
      });
      const Wide<real> inverse_modulus = load_wide(k.shape + i), coupling = load_wide(k.shape + k.stride + i);
      dilatation *= inverse_modulus; // theta - 1
      const Wide<real> volumetric = coupling * dilatation * dilatation / inverse_modulus;
      store_reals(k.energy + i, part.count, (deviation + (inverse_modulus > 0 ? volumetric : 0)) / 2);
    });
}

PLIANT_BODY(corotated_energy)

} // namespace pliant::openmp::PLIANT_ISA
