// Redistribution of what flows only; see kernels/fluid_bond_hold.decl.
#include "kernels/fluid_bond_hold.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void fluid_bond_hold(const kernels::fluid_bond_hold::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint i = 0; i < k.threads; ++i) {
    if (!(k.fluid_stay[i].z > 0)) continue;
    const real most = k.plastic ? k.rate * k.fluid_flow[2 * std::size_t{i} + 1].w : 0;
    auto& place = k.fluid_place[i];
    const Vec3<real> before = xyz(k.fluid_before[i]), shift = xyz(place) - before;
    const real size = norm(shift);
    if (!(size > most)) continue;
    const Vec3<real> kept = before + (most / size) * shift;
    place.x = kept.x, place.y = kept.y, place.z = kept.z;
  }
}

PLIANT_BODY(fluid_bond_hold)

} // namespace pliant::openmp::PLIANT_ISA
