// Velocities; see kernels/fluid_speed.decl.
#include "kernels/fluid_speed.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void fluid_speed(const kernels::fluid_speed::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint i = 0; i < k.threads; ++i) {
    if (!(k.fluid_place[i].w > 0)) continue;
    const auto moved = k.fluid_moved[i];
    k.fluid_velocity[i] = {moved.x / k.time_step, moved.y / k.time_step, moved.z / k.time_step,
                           k.fluid_velocity[i].w};
  }
}

PLIANT_BODY(fluid_speed)

} // namespace pliant::openmp::PLIANT_ISA
