// The numbers of conjugate gradients; see kernels/fluid_viscosity_control.decl.
#include "kernels/fluid_viscosity_control.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"
#include "shaders/common/fluid_viscosity.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void fluid_viscosity_control(const kernels::fluid_viscosity_control::View<real>& k) {
  real* const entry = k.fluid_viscosity;
  if (!k.start && entry[VISCOSITY_STOP] > 0) return;
  double sum_x = 0, sum_y = 0;
  for (uint p = 0; p < k.partial_count; ++p) {
    sum_x += static_cast<double>(k.fluid_partial[p].x);
    sum_y += static_cast<double>(k.fluid_partial[p].y);
  }
  if (k.start) {
    for (uint e = 0; e <= VISCOSITY_KEEP; ++e) entry[e] = 0;
    entry[VISCOSITY_SPEED] = static_cast<real>(sum_x);
    return;
  }
  const real squares = static_cast<real>(sum_x), product = static_cast<real>(sum_y);
  const real iteration = entry[VISCOSITY_ITERATIONS], before = entry[VISCOSITY_LEFT];
  const bool first = iteration == 0;
  if (first) entry[VISCOSITY_FIRST] = squares;
  entry[VISCOSITY_LEFT] = squares;
  const real enough = larger(k.tolerance * k.tolerance * entry[VISCOSITY_FIRST],
                             k.rounding * k.rounding * entry[VISCOSITY_SPEED]);
  const real keep = first ? real(0) : squares / before;
  const real curvature = first ? product : product - keep * squares / entry[VISCOSITY_STEP];
  const bool usable = curvature > 0 && curvature < real(__builtin_huge_valf());
  if (!(squares > enough) || iteration >= static_cast<real>(k.cap) || !usable) {
    entry[VISCOSITY_STOP] = 1;
    return;
  }
  entry[VISCOSITY_KEEP] = keep;
  entry[VISCOSITY_STEP] = squares / curvature;
  entry[VISCOSITY_ITERATIONS] = iteration + 1;
}

PLIANT_BODY(fluid_viscosity_control)

} // namespace pliant::openmp::PLIANT_ISA
