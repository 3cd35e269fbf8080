// Scans the chunks; see kernels/grid_totals.decl.
#include "kernels/grid_totals.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void grid_totals(const kernels::grid_totals::View<real>& k) {
  uint before = 0;
  for (uint chunk = 0; chunk < k.chunks; ++chunk) {
    const uint sum = k.chunk_begin[chunk];
    k.chunk_begin[chunk] = before;
    before += sum;
  }
}

PLIANT_BODY(grid_totals)

} // namespace pliant::openmp::PLIANT_ISA
