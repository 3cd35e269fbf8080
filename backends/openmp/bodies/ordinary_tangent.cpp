// See kernels/ordinary_tangent.decl.
#include "kernels/ordinary_tangent.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void ordinary_tangent(const kernels::ordinary_tangent::View<real>& k) {
  if (k.solver[SOLVER_TAKEN] == 0 || k.solver[SOLVER_LINEAR] == 0) return;
#pragma omp parallel for schedule(static)
  for (uint i = k.first; i < k.first + k.threads; ++i) {
    const Vec3<real> y = xyz(k.position[i]) + xyz(k.extension[i]);
    k.tangent[4 * std::size_t{i}] = {y.x, y.y, y.z, k.extension[i].w};
  }
}

PLIANT_BODY(ordinary_tangent)

} // namespace pliant::openmp::PLIANT_ISA
