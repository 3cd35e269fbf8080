// See kernels/coarse_factor.decl.
#include "kernels/coarse_factor.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void coarse_factor(const kernels::coarse_factor::View<real>& k) {
  if (k.solver[SOLVER_TAKEN] == 0 || k.solver[SOLVER_LINEAR] == 0) return;
  constexpr uint group = kernels::coarse_factor::group_size;
  for (uint body = 0; body < k.threads / group; ++body) {
    const uint first = k.first_node + 8 * body;
    real a[24][24] = {};
    for (uint n = first; n < first + 8; ++n)
      for (uint slot = 0; slot < 27; ++slot) {
        const uint other = k.neighbour[(n / 16 * 27 + slot) * 16 + n % 16];
        if (other == n && slot != 13) continue;
        const real* block = k.matrix + (std::size_t{n / 16} * 27 + slot) * 144 + n % 16;
        for (uint r = 0; r < 3; ++r)
          for (uint c = 0; c < 3; ++c)
            a[3 * (n - first) + r][3 * (other - first) + c] = block[16 * (3 * r + c)];
      }
    for (uint r = 0; r < 24; ++r) a[r][r] *= 1 + real(1e-5);
    real* const factor = k.factor + std::size_t{576} * body;
    for (uint r = 0; r < 24; ++r)
      for (uint c = 0; c < 24; ++c) {
        real value = 0;
        if (c < r) {
          value = a[r][c];
          for (uint i = 0; i < c; ++i) value -= a[r][i] * a[c][i];
          value *= factor[25 * c];
          a[r][c] = value;
        } else if (c == r) {
          real pivot = a[r][r];
          for (uint i = 0; i < r; ++i) pivot -= a[r][i] * a[r][i];
          value = pivot > 0 ? 1 / root(pivot) : 0;
        }
        factor[24 * r + c] = value;
      }
  }
}

PLIANT_BODY(coarse_factor)

} // namespace pliant::openmp::PLIANT_ISA
