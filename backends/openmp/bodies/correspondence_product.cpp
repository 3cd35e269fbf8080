// See kernels/correspondence_product.decl.
#include "kernels/correspondence_product.h"
#include "backends/openmp/body.h"
#include "backends/openmp/simd_tensor.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void correspondence_product(const kernels::correspondence_product::View<real>& k) {
  if (k.solver[SOLVER_LINEAR] == 0) return;
  const real unit = grid_unit(k.unit);
#pragma omp parallel for schedule(static)
  for (uint slice = 0; slice < slice_count(k.threads); ++slice)
    for_each_part(k, slice, [&](const Part<real>& part, uint local) {
      const uint i = part.first;
      const Wide4<real> pi = gather(k.direction, part.index);
      WideMat3<real> s{};
      for_each_bond_of_part(k, local, [&](const uint* j, Wide3<real> xi, Wide<real> c_out, Wide<real>) {
        const Wide4<real> pj = gather(k.direction, j);
        add_outer(s, Wide3<real>{c_out * (pj.x - pi.x), c_out * (pj.y - pi.y), c_out * (pj.z - pi.z)}, xi);
      });
      const WideMat3<real> inverse_shape = symmetric_rows_wide(k.shape, 11, k.stride, i);
      const Wide4<real> x = gather<4>(k.tangent, part.index), y = gather<4>(k.tangent + 1, part.index),
                        z = gather<4>(k.tangent + 2, part.index);
      const WideMat3<real> f{{x.x, x.y, x.z}, {y.x, y.y, y.z}, {z.x, z.y, z.z}}, cof = cofactor<real>(f);
      const WideMat3<real> df = product<real>(times<real>(unit * load_wide(k.shape + i), s), inverse_shape);
      const Wide<real> stiffness = 1 + load_wide(k.shape + k.stride + i) / real(1.5); // lambda / mu
      const WideMat3<real> stress =
          plus<real>(plus<real>(times<real>(1 + y.w, df), stiffness * inner(cof, df), cof), x.w,
                     cofactor_change<real>(f, df));
      const WideMat3<real> da = plus<real>(df, spread(real(-1) / 3), product<real>(stress, inverse_shape));
      Real4<real>* const record = k.record + 3 * std::size_t{i};
      store<3>(record, part.count, Wide4<real>{da.x.x, da.x.y, da.x.z, pi.x});
      store<3>(record + 1, part.count, Wide4<real>{da.y.x, da.y.y, da.y.z, pi.y});
      store<3>(record + 2, part.count, Wide4<real>{da.z.x, da.z.y, da.z.z, pi.z});
    });
}

PLIANT_BODY(correspondence_product)

} // namespace pliant::openmp::PLIANT_ISA
