// Cells of ghosts; see kernels/fluid_ghost_cell.decl.
#include "kernels/fluid_ghost_cell.h"
#include "backends/openmp/body.h"
#include "backends/openmp/lattice.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void fluid_ghost_cell(const kernels::fluid_ghost_cell::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint i = 0; i < k.threads; ++i) {
    const auto place = k.ghost_place[i];
    const uint cell =
        place.w != 0 ? lattice_number(k, lattice_at(k, xyz(place))) : k.cells_x * k.cells_y * k.cells_z;
    k.cell_of[k.particle_count + i] = cell;
    __atomic_fetch_add(&k.cell_count[cell], 1u, __ATOMIC_RELAXED); // a sum of counts: order does not matter
  }
}

PLIANT_BODY(fluid_ghost_cell)

} // namespace pliant::openmp::PLIANT_ISA
