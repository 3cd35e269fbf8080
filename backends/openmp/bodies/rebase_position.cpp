// Positions follow their body's origin; see kernels/rebase_position.decl.
#include "kernels/rebase_position.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void rebase_position(const kernels::rebase_position::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint i = 0; i < k.threads; ++i) {
    const auto shift = k.origin_shift[k.owner[i]];
    auto& y = k.position[i];
    y = {y.x - shift.x, y.y - shift.y, y.z - shift.z, y.w};
  }
}

PLIANT_BODY(rebase_position)

} // namespace pliant::openmp::PLIANT_ISA
