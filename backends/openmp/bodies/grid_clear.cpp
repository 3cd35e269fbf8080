// Empties the grid; see kernels/grid_clear.decl.
#include "kernels/grid_clear.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void grid_clear(const kernels::grid_clear::View<real>& k) {
  k.left_out[0] = k.left_out[1] = 0;
#pragma omp parallel for simd schedule(static)
  for (uint cell = 0; cell < k.threads; ++cell) k.cell_count[cell] = 0;
}

PLIANT_BODY(grid_clear)

} // namespace pliant::openmp::PLIANT_ISA
