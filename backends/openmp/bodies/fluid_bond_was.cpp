// Who is where, and was; see kernels/fluid_bond_was.decl.
#include "kernels/fluid_bond_was.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"
#include "shaders/common/fluid.glsl"
#include "shaders/common/fluid_bond.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void fluid_bond_was(const kernels::fluid_bond_was::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint place = 0; place < k.threads; ++place) {
    if (place >= k.particle_count + k.ghost_count) {
      k.fluid_was[place] = {0, 0, 0, 0};
      continue;
    }
    const uint i = k.fluid_particle[place];
    uint family = FAMILY_GHOST;
    if (i < k.particle_count) {
      const uint kind = k.fluid_kind[i], row = ELASTIC_ROWS * (kind >> FLUID_KIND_SHIFT) + ELASTIC_BONDS;
      family = k.fluid_elastic[row].x > 0 ? (kind & FLUID_BODY) + 1 : 0;
    }
    k.fluid_was[place] = {k.near_place_of[i], family, i, 1};
  }
}

PLIANT_BODY(fluid_bond_was)

} // namespace pliant::openmp::PLIANT_ISA
