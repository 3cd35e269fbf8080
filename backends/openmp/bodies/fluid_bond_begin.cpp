// Start of the elastic solve of bonded fluids; see kernels/fluid_bond_begin.decl.
#include "kernels/fluid_bond_begin.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"
#include "shaders/common/fluid_bond.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void fluid_bond_begin(const kernels::fluid_bond_begin::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint i = 0; i < k.threads; ++i) {
    const real mass = k.fluid_place[i].w;
    const auto v = k.fluid_velocity[i];
    const auto was = k.fluid_was[i];
    const bool moves = mass > 0, bonds = mass != 0 && was.y != 0 && was.y != FAMILY_GHOST;
    Real4<real> u{0, 0, 0, 0}, stay{0, 0, 0, 0};
    if (moves || bonds) {
      u = {k.time_step * v.x, k.time_step * v.y, k.time_step * v.z, 0};
      stay.x = 1;
    }
    k.fluid_displacement[i] = u;
    u.w = moves ? mass / (k.time_step * k.time_step) : real(-1);
    k.fluid_target[i] = u;
    if (bonds) {
      stay.z = k.fluid_elastic[ELASTIC_ROWS * static_cast<uint>(static_cast<int>(v.w)) + ELASTIC_BONDS].x;
      stay.w = v.w;
    }
    k.fluid_stay[i] = stay;
    if (!k.plastic) continue;
    Real4<real> so_far{0, 0, 0, 0};
    if (bonds) so_far = k.fluid_flow_earlier[2 * std::size_t{was.x}];
    so_far.w = 0;
    k.fluid_flow[2 * std::size_t{i}] = so_far;
    k.fluid_flow[2 * std::size_t{i} + 1] = {0, 1, 1, 0};
  }
}

PLIANT_BODY(fluid_bond_begin)

} // namespace pliant::openmp::PLIANT_ISA
