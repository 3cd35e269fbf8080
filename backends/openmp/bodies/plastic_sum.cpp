// One row for the step; see kernels/plastic_sum.decl.
#include "kernels/plastic_sum.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void plastic_sum(const kernels::plastic_sum::View<real>& k) {
  double flowing = 0, taken = 0, gained = 0; // one thread: the same bits for any number of them
  real largest = 0, lost = 0;
  for (std::size_t i = 0; i < k.particle_count; ++i) {
    const auto so_far = k.flow[2 * i];
    flowing += static_cast<double>(so_far.w);
    taken += static_cast<double>(so_far.y);
    gained += static_cast<double>(so_far.z);
    largest = larger(largest, so_far.x);
    const auto stays = k.flow[2 * i + 1];
    lost = larger(lost, 1 - smaller(stays.y, stays.z));
  }
  real* const to = k.plastic_row + std::size_t{5} * k.row;
  to[0] = static_cast<real>(flowing);
  to[1] = static_cast<real>(taken);
  to[2] = largest;
  to[3] = static_cast<real>(gained);
  to[4] = lost;
}

PLIANT_BODY(plastic_sum)

} // namespace pliant::openmp::PLIANT_ISA
