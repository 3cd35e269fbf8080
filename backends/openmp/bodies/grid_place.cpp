// Places particles by cell; see kernels/grid_place.decl.
#include "kernels/grid_place.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void grid_place(const kernels::grid_place::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint i = 0; i < k.threads; ++i)
    k.placed[__atomic_fetch_add(&k.cell_next[k.cell_of[i]], 1u, __ATOMIC_RELAXED)] = i;
}

PLIANT_BODY(grid_place)

} // namespace pliant::openmp::PLIANT_ISA
