// See kernels/fluid_viscosity_update.decl.
#include "kernels/fluid_viscosity_update.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"
#include "shaders/common/fluid_viscosity.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void fluid_viscosity_update(const kernels::fluid_viscosity_update::View<real>& k) {
  if (k.fluid_viscosity[VISCOSITY_STOP] > 0) return;
  const real keep = k.fluid_viscosity[VISCOSITY_KEEP], along = k.fluid_viscosity[VISCOSITY_STEP];
#pragma omp parallel for schedule(static)
  for (uint i = 0; i < k.threads; ++i) {
    const auto u = k.fluid_residual[i], v = k.fluid_velocity[i];
    Vec3<real> p = xyz(u), image = xyz(k.fluid_image[i]);
    if (keep != 0) { // at first there is no last direction
      p = p + keep * xyz(k.fluid_direction[i]);
      image = image + keep * xyz(k.fluid_direction_image[i]);
    }
    k.fluid_direction[i] = {p.x, p.y, p.z, 0};
    k.fluid_direction_image[i] = {image.x, image.y, image.z, 0};
    if (!(u.w > 0)) continue;
    k.fluid_residual[i] = {u.x - along * image.x, u.y - along * image.y, u.z - along * image.z, u.w};
    k.fluid_velocity[i] = {v.x + along * p.x, v.y + along * p.y, v.z + along * p.z, v.w};
  }
}

PLIANT_BODY(fluid_viscosity_update)

} // namespace pliant::openmp::PLIANT_ISA
