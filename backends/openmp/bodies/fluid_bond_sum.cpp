// One row for the step; see kernels/fluid_bond_sum.decl.
#include "kernels/fluid_bond_sum.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void fluid_bond_sum(const kernels::fluid_bond_sum::View<real>& k) {
  double flowing = 0, taken = 0, gained = 0, stored = 0; // one thread: the same bits for any number of them
  real largest = 0, lost = 0;
  for (std::size_t i = 0; i < k.place_count; ++i) {
    stored += static_cast<double>(k.fluid_energy[i]);
    if (!k.plastic) continue;
    const auto so_far = k.fluid_flow[2 * i], stays = k.fluid_flow[2 * i + 1];
    flowing += static_cast<double>(so_far.w);
    taken += static_cast<double>(so_far.y);
    gained += static_cast<double>(so_far.z);
    largest = larger(largest, so_far.x);
    lost = larger(lost, 1 - smaller(stays.y, stays.z));
  }
  real* const to = k.bond_row + std::size_t{6} * k.row;
  to[0] = static_cast<real>(flowing);
  to[1] = static_cast<real>(taken);
  to[2] = largest;
  to[3] = static_cast<real>(gained);
  to[4] = lost;
  to[5] = static_cast<real>(stored);
}

PLIANT_BODY(fluid_bond_sum)

} // namespace pliant::openmp::PLIANT_ISA
