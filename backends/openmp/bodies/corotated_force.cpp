// Forces of law M4, gathered; see kernels/corotated_force.decl.
#include "kernels/corotated_force.h"
#include "backends/openmp/body.h"
#include "backends/openmp/simd.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void corotated_force(const kernels::corotated_force::View<real>& k) {
  if (k.product ? k.solver[SOLVER_LINEAR] == 0 : k.solver[SOLVER_STOP] > 0) return;
  const real unit = grid_unit(k.unit);
#pragma omp parallel for schedule(static)
  for (uint slice = 0; slice < slice_count(k.threads); ++slice)
    for_each_part(k, slice, [&](const Part<real>& part, uint local) {
      const Wide4<real> i0 = gather<3>(k.record, part.index), i1 = gather<3>(k.record + 1, part.index),
                        i2 = gather<3>(k.record + 2, part.index);
      // A_i is the same for all bonds of i: sum c_ij A_i xi = A_i (sum c_ij xi).
      Wide3<real> linear{}, rest{}, own{};
      for_each_bond_of_part(k, local, [&](const uint* j, Wide3<real> xi, Wide<real> c_out, Wide<real> c_in) {
        const Wide<real> c = c_out + c_in;
        own.x += c_out * xi.x, own.y += c_out * xi.y, own.z += c_out * xi.z;
        const Wide<real> x = c_in * xi.x, y = c_in * xi.y, z = c_in * xi.z;
        const Wide4<real> j0 = gather<3>(k.record, j);
        linear.x += c * (j0.w - i0.w);
        rest.x += j0.x * x + j0.y * y + j0.z * z;
        const Wide4<real> j1 = gather<3>(k.record + 1, j);
        linear.y += c * (j1.w - i1.w);
        rest.y += j1.x * x + j1.y * y + j1.z * z;
        const Wide4<real> j2 = gather<3>(k.record + 2, j);
        linear.z += c * (j2.w - i2.w);
        rest.z += j2.x * x + j2.y * y + j2.z * z;
      });
      rest.x += i0.x * own.x + i0.y * own.y + i0.z * own.z;
      rest.y += i1.x * own.x + i1.y * own.y + i1.z * own.z;
      rest.z += i2.x * own.x + i2.y * own.y + i2.z * own.z;
      const Wide4<real> start = k.product ? Wide4<real>{} : gather(k.linear_start, part.index);
      store(k.force + part.first, part.count,
            Wide4<real>{start.x + (linear.x - unit * rest.x), start.y + (linear.y - unit * rest.y),
                        start.z + (linear.z - unit * rest.z), start.w});
    });
}

PLIANT_BODY(corotated_force)

} // namespace pliant::openmp::PLIANT_ISA
