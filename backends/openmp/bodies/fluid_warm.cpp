// Multipliers to start with; see kernels/fluid_warm.decl.
#include "kernels/fluid_warm.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void fluid_warm(const kernels::fluid_warm::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint i = 0; i < k.threads; ++i)
    k.fluid_lambda[i] = k.fluid_total[i] = k.share * smaller(k.fluid_start[i].w, real(0));
}

PLIANT_BODY(fluid_warm)

} // namespace pliant::openmp::PLIANT_ISA
