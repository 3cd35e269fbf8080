// See kernels/ordinary_product_force.decl.
#include "kernels/ordinary_product_force.h"
#include "backends/openmp/body.h"
#include "backends/openmp/rest.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void ordinary_product_force(const kernels::ordinary_product_force::View<real>& k) {
  if (k.solver[SOLVER_LINEAR] == 0) return;
  const real unit = grid_unit(k.unit);
  with_rest(k, [&](auto plastic) {
#pragma omp parallel for schedule(static)
    for (uint s = 0; s < slice_count(k.threads); ++s)
      for_each_part(k, s, [&](const Part<real>& part, uint local) {
        const Wide4<real> yi = gather<4>(k.tangent, part.index), pi = gather(k.extension, part.index);
        Wide3<real> sum{};
        for_each_bond_at_rest_of_part<plastic()>(
            k, local, [&](const uint* j, const Wide3<real>& xi, const WideRestBond<real>& at_rest) {
              const auto& [c_out, c_in, p_out, p_in] = at_rest;
              const Wide4<real> yj = gather<4>(k.tangent, j), pj = gather(k.extension, j);
              const WideBond<real> b =
                  wide_bond<real>(Wide3<real>{yj.x - yi.x, yj.y - yi.y, yj.z - yi.z}, xi, unit);
              const Wide3<real> dy{pj.x - pi.x, pj.y - pi.y, pj.z - pi.z};
              const Wide<real> along = dot(b.n, dy), x_out = b.x * p_out, x_in = b.x * p_in;
              const Wide<real> pull =
                  c_out * (b.size - x_out + x_out * yi.w) + c_in * (b.size - x_in + x_in * yj.w);
              const Wide<real> rate =
                  (c_out + c_in) * along + b.x * (c_out * p_out * pi.w + c_in * p_in * pj.w);
              const Wide<real> least = real(1e-3) * b.x + real(1e-30);
              const Wide<real> across = pull / (b.size > least ? b.size : least);
              const Wide<real> extra = rate - across * along;
              sum = {sum.x + extra * b.n.x + across * dy.x, sum.y + extra * b.n.y + across * dy.y,
                     sum.z + extra * b.n.z + across * dy.z};
            });
        store(k.force + part.first, part.count, Wide4<real>{sum.x, sum.y, sum.z, Wide<real>{}});
      });
  });
}

PLIANT_BODY(ordinary_product_force)

} // namespace pliant::openmp::PLIANT_ISA
