// Counts particles by cell; see kernels/grid_count.decl.
#include "kernels/grid_count.h"
#include "backends/openmp/body.h"
#include "backends/openmp/cells.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void grid_count(const kernels::grid_count::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint i = 0; i < k.threads; ++i) {
    const uint cell = cell_number(cell_at(xyz(k.start[i]) + xyz(k.displacement[i]), k.per_cell), k.mask);
    k.cell_of[i] = cell;
    __atomic_fetch_add(&k.cell_count[cell], 1u, __ATOMIC_RELAXED); // a sum of counts: order does not matter
  }
}

PLIANT_BODY(grid_count)

} // namespace pliant::openmp::PLIANT_ISA
