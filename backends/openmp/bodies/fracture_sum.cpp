// One row for the step; see kernels/fracture_sum.decl.
#include "kernels/fracture_sum.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void fracture_sum(const kernels::fracture_sum::View<real>& k) {
  double broken = 0, released = 0; // one thread: the same bits for any number of them
  for (uint i = 0; i < k.particle_count; ++i) {
    broken += static_cast<double>(k.shape[k.broken_at + i]);
    released += static_cast<double>(k.released[i]);
  }
  k.fracture[2 * k.row] = static_cast<real>(broken / 2);
  k.fracture[2 * k.row + 1] = static_cast<real>(released);
}

PLIANT_BODY(fracture_sum)

} // namespace pliant::openmp::PLIANT_ISA
