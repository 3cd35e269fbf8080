// Orders each cell by particle; see kernels/grid_sort.decl.
#include "kernels/grid_sort.h"
#include "backends/openmp/body.h"
#include "backends/openmp/order.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void grid_sort(const kernels::grid_sort::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint cell = 0; cell < k.cells; ++cell) {
    const uint begin = k.cell_begin[cell], end = k.cell_begin[cell + 1];
    for (uint place = begin; place < end; ++place) k.sorted[place] = k.placed[place];
    sort(k.sorted + begin, end - begin);
    for (uint place = begin; place < end; ++place) {
      const uint i = k.sorted[place];
      const Vec3<real> x = xyz(k.start[i]) + xyz(k.displacement[i]);
      k.sorted_place[place] = {x.x, x.y, x.z, static_cast<real>(k.owner[i])};
    }
  }
}

PLIANT_BODY(grid_sort)

} // namespace pliant::openmp::PLIANT_ISA
