// See kernels/ordinary_product.decl.
#include "kernels/ordinary_product.h"
#include "backends/openmp/body.h"
#include "backends/openmp/rest.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void ordinary_product(const kernels::ordinary_product::View<real>& k) {
  if ((k.plastic ? k.gate[3].y : k.solver[SOLVER_LINEAR]) == 0) return;
  const real unit = grid_unit(k.unit);
  with_rest(k, [&](auto plastic) {
#pragma omp parallel for schedule(static)
    for (uint s = 0; s < slice_count(k.threads); ++s)
      for_each_part(k, s, [&](const Part<real>& part, uint local) {
        const Wide4<real> yi = gather<4>(k.tangent, part.index), pi = gather(k.direction, part.index);
        Wide<real> lengthening{};
        for_each_bond_at_rest_of_part<plastic()>(
            k, local, [&](const uint* j, const Wide3<real>& xi, const WideRestBond<real>& at_rest) {
              const Wide4<real> yj = gather<4>(k.tangent, j), pj = gather(k.direction, j);
              const WideBond<real> b =
                  wide_bond<real>(Wide3<real>{yj.x - yi.x, yj.y - yi.y, yj.z - yi.z}, xi, unit);
              const Wide<real> along = b.n.x * (pj.x - pi.x) + b.n.y * (pj.y - pi.y) + b.n.z * (pj.z - pi.z);
              lengthening += at_rest.c_out * (b.x * at_rest.p_out) * along;
            });
        const uint i = part.first;
        const Wide<real> rate = load_wide(k.shape + k.stride + i) * load_wide(k.shape + i) * lengthening;
        store(k.extension + i, part.count, Wide4<real>{pi.x, pi.y, pi.z, rate});
      });
  });
}

PLIANT_BODY(ordinary_product)

} // namespace pliant::openmp::PLIANT_ISA
