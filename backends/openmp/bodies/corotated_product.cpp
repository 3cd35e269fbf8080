// See kernels/corotated_product.decl.
#include "kernels/corotated_product.h"
#include "backends/openmp/body.h"
#include "backends/openmp/simd_rotation.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void corotated_product(const kernels::corotated_product::View<real>& k) {
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
      const Wide4<real> a = gather<4>(k.tangent + 1, part.index), b = gather<4>(k.tangent + 2, part.index);
      const Wide<real> scale = unit * gather<4>(k.tangent + 3, part.index).x;
      const WideMat3<real> r = rotation_matrix<real>(gather<4>(k.tangent, part.index));
      const WideMat3<real> m = transposed_product(r, s);
      const Wide3<real> axial{scale * (m.z.y - m.y.z), scale * (m.x.z - m.z.x), scale * (m.y.x - m.x.y)};
      const Wide<real> x = b.z * (a.x * axial.x + a.y * axial.y + a.z * axial.z);
      const Wide<real> y = b.z * (a.y * axial.x + a.w * axial.y + b.x * axial.z);
      const Wide<real> z = b.z * (a.z * axial.x + b.x * axial.y + b.y * axial.z);
      const Wide<real> t = -b.w * scale * (m.x.x + m.y.y + m.z.z);
      // dA = R (t 1 + [w]x), row by row.
      const auto row = [&](const Wide3<real>& v, Wide<real> p) {
        return Wide4<real>{t * v.x + z * v.y - y * v.z, t * v.y + x * v.z - z * v.x,
                           t * v.z + y * v.x - x * v.y, p};
      };
      Real4<real>* const record = k.record + 3 * std::size_t{i};
      store<3>(record, part.count, row(r.x, pi.x));
      store<3>(record + 1, part.count, row(r.y, pi.y));
      store<3>(record + 2, part.count, row(r.z, pi.z));
    });
}

PLIANT_BODY(corotated_product)

} // namespace pliant::openmp::PLIANT_ISA
