// See kernels/fluid_bond_end.decl.
#include "kernels/fluid_bond_end.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void fluid_bond_end(const kernels::fluid_bond_end::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint i = 0; i < k.threads; ++i) {
    auto& place = k.fluid_place[i];
    if (!(place.w > 0)) continue;
    const auto u = k.fluid_best[i], start = k.fluid_start[i];
    auto& v = k.fluid_velocity[i];
    v.x = u.x / k.time_step, v.y = u.y / k.time_step, v.z = u.z / k.time_step;
    place.x = start.x + u.x, place.y = start.y + u.y, place.z = start.z + u.z;
  }
}

PLIANT_BODY(fluid_bond_end)

} // namespace pliant::openmp::PLIANT_ISA
