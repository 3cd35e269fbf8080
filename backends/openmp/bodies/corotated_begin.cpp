// What one step's solve keeps of the positions at its start; see kernels/corotated_begin.decl.
#include "kernels/corotated_begin.h"
#include "backends/openmp/body.h"
#include "backends/openmp/simd.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void corotated_begin(const kernels::corotated_begin::View<real>& k) {
  const real unit = grid_unit(k.unit);
#pragma omp parallel for schedule(static)
  for (uint slice = 0; slice < slice_count(k.threads); ++slice)
    for_each_part(k, slice, [&](const Part<real>& part, uint local) {
      const uint i = part.first;
      const Wide4<real> yi = gather(k.position, part.index);
      WideMat3<real> s{};
      Wide3<real> linear{};
      for_each_bond_of_part(k, local, [&](const uint* j, Wide3<real> xi, Wide<real> c_out, Wide<real> c_in) {
        const Wide4<real> yj = gather(k.position, j);
        const Wide3<real> y{yj.x - yi.x, yj.y - yi.y, yj.z - yi.z};
        add_outer(s, y, Wide3<real>{c_out * xi.x, c_out * xi.y, c_out * xi.z});
        const Wide<real> c = c_out + c_in;
        linear.x += c * y.x, linear.y += c * y.y, linear.z += c * y.z;
      });
      real* row = k.shape + std::size_t{2} * k.stride + i;
      for (const Wide<real>& value : {s.x.x, s.x.y, s.x.z, s.y.x, s.y.y, s.y.z, s.z.x, s.z.y, s.z.z}) {
        store_reals(row, part.count, unit * value);
        row += k.stride;
      }
      const Wide4<real> start = gather(k.linear_start, part.index);
      store(k.linear_start + i, part.count, Wide4<real>{linear.x, linear.y, linear.z, start.w});
    });
}

PLIANT_BODY(corotated_begin)

} // namespace pliant::openmp::PLIANT_ISA
