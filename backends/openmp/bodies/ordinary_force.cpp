// Forces of law M2, gathered; see kernels/ordinary_force.decl.
#include "kernels/ordinary_force.h"
#include "backends/openmp/body.h"
#include "backends/openmp/rest.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void ordinary_force(const kernels::ordinary_force::View<real>& k) {
  if ((k.plastic ? k.gate[0].x : k.solver[SOLVER_STOP]) > 0) return;
  with_rest(k, [&](auto plastic) {
#pragma omp parallel for schedule(static)
    for (uint local = 0; local < k.threads; ++local) {
      const uint i = k.first + local;
      const Vec3<real> yi = xyz(k.position[i]);
      const auto ui = k.extension[i];
      Vec3<real> sum{0, 0, 0};
      for_each_bond_at_rest<plastic()>(k, local, [&](uint j, Vec3<real> xi, const RestBond<real>& at_rest) {
        const auto uj = k.extension[j];
        const Vec3<real> y = (xyz(k.position[j]) - yi) + (xyz(uj) - xyz(ui));
        const real x = norm(xi), size = norm(y), x_out = x * at_rest.p_out, x_in = x * at_rest.p_in;
        const real pull =
            at_rest.c_out * (size - x_out + x_out * ui.w) + at_rest.c_in * (size - x_in + x_in * uj.w);
        sum = sum + pull * bond_direction(y, xi);
      });
      k.force[i] = {sum.x, sum.y, sum.z, k.linear_start[i].w};
    }
  });
}

PLIANT_BODY(ordinary_force)

} // namespace pliant::openmp::PLIANT_ISA
