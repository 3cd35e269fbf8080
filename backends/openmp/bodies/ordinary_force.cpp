// Forces of law M2, gathered; see kernels/ordinary_force.decl.
#include "kernels/ordinary_force.h"
#include "backends/openmp/body.h"
#include "backends/openmp/rest.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void ordinary_force(const kernels::ordinary_force::View<real>& k) {
  if ((k.plastic ? k.gate[0].x : k.solver[SOLVER_STOP]) > 0) return;
  const real unit = grid_unit(k.unit);
  with_rest(k, [&](auto plastic) {
#pragma omp parallel for schedule(static)
    for (uint s = 0; s < slice_count(k.threads); ++s)
      for_each_part(k, s, [&](const Part<real>& part, uint local) {
        const Wide4<real> yi = gather(k.position, part.index), ui = gather(k.extension, part.index);
        Wide3<real> sum{};
        for_each_bond_at_rest_of_part<plastic()>(
            k, local, [&](const uint* j, const Wide3<real>& xi, const WideRestBond<real>& at_rest) {
              const Wide4<real> yj = gather(k.position, j), uj = gather(k.extension, j);
              const WideBond<real> b =
                  wide_bond<real>(Wide3<real>{(yj.x - yi.x) + (uj.x - ui.x), (yj.y - yi.y) + (uj.y - ui.y),
                                              (yj.z - yi.z) + (uj.z - ui.z)},
                                  xi, unit);
              const Wide<real> x_out = b.x * at_rest.p_out, x_in = b.x * at_rest.p_in;
              const Wide<real> pull = at_rest.c_out * (b.size - x_out + x_out * ui.w) +
                                      at_rest.c_in * (b.size - x_in + x_in * uj.w);
              sum = {sum.x + pull * b.n.x, sum.y + pull * b.n.y, sum.z + pull * b.n.z};
            });
        const Wide4<real> start = gather(k.linear_start, part.index);
        store(k.force + part.first, part.count, Wide4<real>{sum.x, sum.y, sum.z, start.w});
      });
  });
}

PLIANT_BODY(ordinary_force)

} // namespace pliant::openmp::PLIANT_ISA
