// Forces of law M2, gathered; see kernels/ordinary_force.decl.
#include "kernels/ordinary_force.h"
#include "backends/openmp/body.h"
#include "backends/openmp/slice.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void ordinary_force(const kernels::ordinary_force::View<real>& k) {
  if (k.solver[SOLVER_STOP] > 0) return;
#pragma omp parallel for schedule(static)
  for (uint local = 0; local < k.threads; ++local) {
    const uint i = k.first + local;
    const Vec3<real> yi = xyz(k.position[i]);
    const auto ui = k.extension[i];
    Vec3<real> sum{0, 0, 0};
    for_each_bond(k, local, [&](uint j, Vec3<real> xi, real c_out, real c_in) {
      const auto uj = k.extension[j];
      const Vec3<real> y = (xyz(k.position[j]) - yi) + (xyz(uj) - xyz(ui));
      const real x = norm(xi), stretch = norm(y) - x;
      sum = sum + (c_out * (stretch + x * ui.w) + c_in * (stretch + x * uj.w)) * bond_direction(y, xi);
    });
    k.force[i] = {sum.x, sum.y, sum.z, k.linear_start[i].w};
  }
}

PLIANT_BODY(ordinary_force)

} // namespace pliant::openmp::PLIANT_ISA
