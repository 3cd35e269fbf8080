// Cells of a fluid's particles; see kernels/fluid_cell.decl.
#include "kernels/fluid_cell.h"
#include "backends/openmp/body.h"
#include "backends/openmp/lattice.h"
#include "shaders/common/fluid.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void fluid_cell(const kernels::fluid_cell::View<real>& k) {
#pragma omp parallel
  {
    // Particles of a cell often follow one another: they are added at once. Of counts the order does not
    // matter.
    uint last = 0, count = 0;
    const auto add = [&] {
      if (count > 0) __atomic_fetch_add(&k.cell_count[last], count, __ATOMIC_RELAXED);
    };
#pragma omp for schedule(static)
    for (uint i = 0; i < k.threads; ++i) {
      uint cell = k.cells_x * k.cells_y * k.cells_z;
      if (k.position[i].w != 0) {
        const Flight<real> flight =
            free_flight(k, k.position[i], k.velocity[i], k.origin[k.fluid_kind[i] & FLUID_BODY]);
        cell = lattice_number(k, lattice_at(k, flight.place));
      }
      k.cell_of[i] = cell;
      if (cell != last) {
        add();
        last = cell;
        count = 0;
      }
      ++count;
    }
    add();
  }
}

PLIANT_BODY(fluid_cell)

} // namespace pliant::openmp::PLIANT_ISA
