// What the density constraint starts with; see kernels/fluid_warm.decl.
#include "kernels/fluid_warm.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void fluid_warm(const kernels::fluid_warm::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint i = 0; i < k.threads; ++i) {
    const auto v = k.fluid_velocity[i];
    k.fluid_total[i] = k.share * smaller(k.fluid_start[i].w, real(0));
    k.fluid_moved[i] = {k.time_step * v.x, k.time_step * v.y, k.time_step * v.z, 0};
  }
}

PLIANT_BODY(fluid_warm)

} // namespace pliant::openmp::PLIANT_ISA
