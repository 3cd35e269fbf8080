// A layer is born; see kernels/fluid_emit.decl.
#include "kernels/fluid_emit.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void fluid_emit(const kernels::fluid_emit::View<real>& k) {
  const Vec3<real> flown{k.flown_x, k.flown_y, k.flown_z};
#pragma omp parallel for schedule(static)
  for (uint point = 0; point < k.threads; ++point) {
    const auto from = k.emitter_point[k.first + point];
    const Vec3<real> place = xyz(from) + flown;
    const uint i = k.emitter_slot[point];
    k.position[i] = {place.x, place.y, place.z, from.w};
    k.velocity[i] = {k.speed_x, k.speed_y, k.speed_z, k.held};
  }
  k.emitter_count[2 * k.emitter] += k.threads;
}

PLIANT_BODY(fluid_emit)

} // namespace pliant::openmp::PLIANT_ISA
