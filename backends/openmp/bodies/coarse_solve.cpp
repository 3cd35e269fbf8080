// See kernels/coarse_solve.decl.
#include "kernels/coarse_solve.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void coarse_solve(const kernels::coarse_solve::View<real>& k) {
  if (k.solver[SOLVER_LINEAR] == 0) return;
  constexpr uint group = kernels::coarse_solve::group_size;
  for (uint body = 0; body < k.threads / group; ++body) {
    const uint first = k.first_node + 8 * body;
    const real* const factor = k.factor + std::size_t{576} * body;
    real x[24];
    for (uint n = 0; n < 8; ++n) {
      const auto b = k.coarse_load[first + n];
      x[3 * n] = b.x, x[3 * n + 1] = b.y, x[3 * n + 2] = b.z;
    }
    for (uint r = 0; r < 24; ++r) {
      for (uint c = 0; c < r; ++c) x[r] -= factor[24 * r + c] * x[c];
      x[r] *= factor[25 * r];
    }
    for (uint r = 24; r-- > 0;) {
      for (uint c = r + 1; c < 24; ++c) x[r] -= factor[24 * c + r] * x[c];
      x[r] *= factor[25 * r];
    }
    for (uint n = 0; n < 8; ++n) k.coarse_result[first + n] = {x[3 * n], x[3 * n + 1], x[3 * n + 2], 0};
  }
}

PLIANT_BODY(coarse_solve)

} // namespace pliant::openmp::PLIANT_ISA
