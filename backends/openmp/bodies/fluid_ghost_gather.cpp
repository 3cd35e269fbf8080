// Ghosts in sorted order; see kernels/fluid_ghost_gather.decl.
#include "kernels/fluid_ghost_gather.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void fluid_ghost_gather(const kernels::fluid_ghost_gather::View<real>& k) {
  const uint last = smaller(k.threads, k.particle_count + k.ghost_count);
#pragma omp parallel for schedule(static)
  for (uint place = 0; place < last; ++place) {
    const uint i = k.fluid_particle[place];
    if (i < k.particle_count) continue;
    const auto at = k.ghost_place[i - k.particle_count];
    if (at.w == 0) continue;
    k.fluid_place[place] = at;
    k.fluid_velocity[place] = k.ghost_velocity[i - k.particle_count];
    k.fluid_start[place] = {at.x, at.y, at.z, 0};
  }
}

PLIANT_BODY(fluid_ghost_gather)

} // namespace pliant::openmp::PLIANT_ISA
