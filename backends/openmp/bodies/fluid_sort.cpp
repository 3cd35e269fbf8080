// Orders each cell by particle; see kernels/fluid_sort.decl.
#include "kernels/fluid_sort.h"
#include "backends/openmp/body.h"
#include "backends/openmp/order.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void fluid_sort(const kernels::fluid_sort::View<real>& k) {
#pragma omp parallel for schedule(static, 1024)
  for (uint cell = 0; cell < k.cells; ++cell) {
    const uint begin = k.cell_begin[cell], end = k.cell_begin[cell + 1];
    for (uint place = begin; place < end; ++place) k.fluid_particle[place] = k.placed[place];
    if (cell + 1 < k.cells) sort(k.fluid_particle + begin, end - begin); // the last: removed, in no order
  }
}

PLIANT_BODY(fluid_sort)

} // namespace pliant::openmp::PLIANT_ISA
