// Sums chunks of cells; see kernels/grid_sum.decl.
#include "kernels/grid_sum.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"
#include "shaders/common/contact.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void grid_sum(const kernels::grid_sum::View<real>& k) {
  const uint chunks = (k.cells + SCAN_CHUNK - 1) / SCAN_CHUNK;
#pragma omp parallel for schedule(static)
  for (uint chunk = 0; chunk < chunks; ++chunk) {
    uint sum = 0;
    for (uint cell = SCAN_CHUNK * chunk; cell < smaller(SCAN_CHUNK * (chunk + 1), k.cells); ++cell)
      sum += k.cell_count[cell];
    k.chunk_begin[chunk] = sum;
  }
}

PLIANT_BODY(grid_sum)

} // namespace pliant::openmp::PLIANT_ISA
