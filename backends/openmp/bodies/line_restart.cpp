// See kernels/line_restart.decl.
#include "kernels/line_restart.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void line_restart(const kernels::line_restart::View<real>& k) {
  if (k.solver[SOLVER_STOP] == 1) return;
  k.solver[SOLVER_STOP] = 0;
  k.solver[SOLVER_LINEAR] = 0;
}

PLIANT_BODY(line_restart)

} // namespace pliant::openmp::PLIANT_ISA
