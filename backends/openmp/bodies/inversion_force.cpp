// Forces against inversion, gathered; see kernels/inversion_force.decl.
#include "kernels/inversion_force.h"
#include "backends/openmp/body.h"
#include "backends/openmp/slice.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void inversion_force(const kernels::inversion_force::View<real>& k) {
  if (k.product ? k.solver[SOLVER_LINEAR] == 0 : k.solver[SOLVER_STOP] > 0) return;
#pragma omp parallel for schedule(static)
  for (uint local = 0; local < k.threads; ++local) {
    const uint i = k.first + local;
    const Real4<real>* const own = k.inversion + 3 * std::size_t{i};
    Vec3<real> sum{0, 0, 0};
    real stiffness = 0;
    for_each_bond(k, local, [&](uint j, Vec3<real> xi, real c_out, real c_in) {
      const Real4<real>* const other = k.inversion + 3 * std::size_t{j};
      const auto row = [&](int r) { return dot(c_out * xyz(own[r]) + c_in * xyz(other[r]), xi); };
      sum = sum + Vec3<real>{row(0), row(1), row(2)};
      stiffness += c_out * own[0].w + c_in * other[0].w;
    });
    const auto before = k.force[i];
    k.force[i] = {before.x + sum.x, before.y + sum.y, before.z + sum.z,
                  before.w + (k.product ? real(0) : stiffness)};
  }
}

PLIANT_BODY(inversion_force)

} // namespace pliant::openmp::PLIANT_ISA
