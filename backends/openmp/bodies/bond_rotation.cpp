// See kernels/bond_rotation.decl.
#include "kernels/bond_rotation.h"
#include "backends/openmp/body.h"
#include "backends/openmp/simd_rotation.h"
#include "backends/openmp/simd_tensor.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void bond_rotation(const kernels::bond_rotation::View<real>& k) {
  if (k.solver[SOLVER_TAKEN] == 0 || k.solver[SOLVER_LINEAR] == 0) return;
  const real unit = grid_unit(k.unit);
#pragma omp parallel for schedule(static)
  for (uint slice = 0; slice < slice_count(k.threads); ++slice)
    for_each_part(k, slice, [&](const Part<real>& part, uint local) {
      const uint i = part.first;
      const Wide4<real> yi = gather(k.position, part.index), ui = gather(k.displacement, part.index);
      WideMat3<real> s{};
      for_each_bond_of_part(k, local, [&](const uint* j, Wide3<real> xi, Wide<real> c_out, Wide<real>) {
        const Wide4<real> yj = gather(k.position, j), uj = gather(k.displacement, j);
        add_outer(s,
                  Wide3<real>{c_out * ((yj.x - yi.x) + (uj.x - ui.x)),
                              c_out * ((yj.y - yi.y) + (uj.y - ui.y)),
                              c_out * ((yj.z - yi.z) + (uj.z - ui.z))},
                  xi);
      });
      const Wide<real> scale = unit * load_wide(k.shape + i);
      const Wide4<real> before = gather(k.rotation, part.index);
      store(k.rotation + i, part.count, polar_rotation(times<real>(scale, s), before, part.count));
    });
}

PLIANT_BODY(bond_rotation)

} // namespace pliant::openmp::PLIANT_ISA
