// Redistribution of what flows only; see kernels/fluid_bond_hold.decl.
#include "kernels/fluid_bond_hold.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void fluid_bond_hold(const kernels::fluid_bond_hold::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint i = 0; i < k.threads; ++i) {
    if (!(k.fluid_stay[i].z > 0)) continue;
    real share = 0;
    if (k.plastic) {
      const auto stays = k.fluid_flow[2 * std::size_t{i} + 1];
      share = 10 * (1 - smaller(stays.y, stays.z));
    }
    if (!(share < 1)) continue;
    const auto before = k.fluid_before[i];
    auto& place = k.fluid_place[i];
    place = {before.x + share * (place.x - before.x), before.y + share * (place.y - before.y),
             before.z + share * (place.z - before.z), place.w};
  }
}

PLIANT_BODY(fluid_bond_hold)

} // namespace pliant::openmp::PLIANT_ISA
