// See kernels/fluid_viscosity_apply.decl.
#include "kernels/fluid_viscosity_apply.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void fluid_viscosity_apply(const kernels::fluid_viscosity_apply::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint i = 0; i < k.threads; ++i) {
    const real mass = k.fluid_place[i].w;
    if (!(mass > 0)) continue;
    const Vec3<real> y = xyz(k.fluid_start[i]) + k.time_step * xyz(k.fluid_velocity[i]);
    k.fluid_place[i] = {y.x, y.y, y.z, mass};
  }
}

PLIANT_BODY(fluid_viscosity_apply)

} // namespace pliant::openmp::PLIANT_ISA
