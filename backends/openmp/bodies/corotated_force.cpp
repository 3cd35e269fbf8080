// Forces of law M4, gathered; see kernels/corotated_force.decl.
#include "kernels/corotated_force.h"
#include "backends/openmp/body.h"
#include "backends/openmp/slice.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void corotated_force(const kernels::corotated_force::View<real>& k) {
  if (k.solver[SOLVER_STOP] > 0) return;
#pragma omp parallel for schedule(static)
  for (uint local = 0; local < k.threads; ++local) {
    const uint i = k.first + local;
    const auto i0 = k.record[3 * i], i1 = k.record[3 * i + 1], i2 = k.record[3 * i + 2];
    Vec3<real> linear{0, 0, 0}, rest{0, 0, 0};
    for_each_bond(k, local, [&](uint j, Vec3<real> xi, real c_out, real c_in) {
      const auto &j0 = k.record[3 * j], &j1 = k.record[3 * j + 1], &j2 = k.record[3 * j + 2];
      linear = linear + (c_out + c_in) * Vec3<real>{j0.w - i0.w, j1.w - i1.w, j2.w - i2.w};
      rest = rest + Vec3<real>{dot(c_out * xyz(i0) + c_in * xyz(j0), xi),
                               dot(c_out * xyz(i1) + c_in * xyz(j1), xi),
                               dot(c_out * xyz(i2) + c_in * xyz(j2), xi)};
    });
    const auto start = k.linear_start[i];
    const Vec3<real> f = xyz(start) + linear - rest;
    k.force[i] = {f.x, f.y, f.z, start.w};
  }
}

PLIANT_BODY(corotated_force)

} // namespace pliant::openmp::PLIANT_ISA
