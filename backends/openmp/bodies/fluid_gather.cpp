// Particles of a fluid in sorted order; see kernels/fluid_gather.decl.
#include "kernels/fluid_gather.h"
#include "backends/openmp/body.h"
#include "backends/openmp/lattice.h"
#include "shaders/common/fluid.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void fluid_gather(const kernels::fluid_gather::View<real>& k) {
  constexpr real far = real(1e15); // m; its square is still a float
#pragma omp parallel for schedule(static)
  for (uint place = 0; place < k.threads; ++place) {
    k.fluid_place[place] = {far, far, far, 0};
    const uint i = place < k.particle_count + k.ghost_count ? k.fluid_particle[place] : k.particle_count;
    if (i >= k.particle_count) {
      k.fluid_velocity[place] = k.fluid_start[place] = {0, 0, 0, 0};
      continue;
    }
    const uint kind = k.fluid_kind[i];
    const auto old = k.position[i], before = k.velocity[i];
    const Flight<real> flight = free_flight(k, old, before, k.origin[kind & FLUID_BODY]);
    k.fluid_start[place] = {flight.start.x, flight.start.y, flight.start.z, before.w};
    k.fluid_velocity[place] = {flight.velocity.x, flight.velocity.y, flight.velocity.z,
                               static_cast<real>(kind >> FLUID_KIND_SHIFT)};
    if (old.w != 0)
      k.fluid_place[place] = {flight.place.x, flight.place.y, flight.place.z, flight.held ? -old.w : old.w};
  }
}

PLIANT_BODY(fluid_gather)

} // namespace pliant::openmp::PLIANT_ISA
