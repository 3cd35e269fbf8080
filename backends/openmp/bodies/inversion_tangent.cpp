// See kernels/inversion_tangent.decl.
#include "kernels/inversion_tangent.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void inversion_tangent(const kernels::inversion_tangent::View<real>& k) {
  if (k.solver[SOLVER_TAKEN] == 0 || k.solver[SOLVER_LINEAR] == 0) return;
#pragma omp parallel for schedule(static)
  for (uint local = 0; local < k.threads; ++local) {
    const uint i = k.first + local;
    k.inverted[i] = k.inversion[3 * std::size_t{i}].w > 0 ? real(1) : real(0);
  }
}

PLIANT_BODY(inversion_tangent)

} // namespace pliant::openmp::PLIANT_ISA
