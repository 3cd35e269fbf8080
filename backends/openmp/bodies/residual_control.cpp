// The residual and what follows from it; see kernels/residual_control.decl.
#include "kernels/residual_control.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void residual_control(const kernels::residual_control::View<real>& k) {
  real sum = 0, impulse = 0, displaced = 0, mark = 0;
  for (uint p = 0; p < k.partial_count; ++p) {
    const auto part = k.residual_partial[p];
    sum += part.x;
    impulse += part.y;
    displaced += part.z;
    mark += part.w;
    if (mark >= 1) mark -= 1; // see shaders/common/touched.glsl
  }
  real* const solver = k.solver;
  if (k.iteration > 0 && solver[SOLVER_STOP] > 0) {
    solver[SOLVER_ACTION] = 0;
    return;
  }
  const real e = root(sum), moved = root(displaced);
  const real low = moved < real(1e30) ? larger(k.floor_residual, k.rounding * moved) : k.floor_residual;
  const bool finite = __builtin_isfinite(e);
  if (k.iteration == 0) {
    solver[SOLVER_STOP] = 0;
    solver[SOLVER_ONE_MINUS_RHO] = k.one_minus_rho;
    solver[SOLVER_GAMMA] = k.gamma;
    solver[SOLVER_FIRST] = e;
    solver[SOLVER_BEST] = finite ? e : real(3e38);
    solver[SOLVER_RESTARTS] = 0;
    solver[SOLVER_ITERATIONS] = 0;
    solver[SOLVER_REASON] = 3;
    solver[SOLVER_DELAY] = static_cast<real>(k.delay);
    solver[SOLVER_ACCELERATE] = static_cast<real>(k.accelerate);
    solver[SOLVER_SCALE] = root(impulse);
    solver[SOLVER_TRIAL] = 0;
    solver[SOLVER_TOUCHED] = mark;
  }
  solver[SOLVER_CURRENT] = e;
  solver[SOLVER_FLOOR] = low;
  solver[SOLVER_ACTION] = 0;
  const bool good = e <= low || e <= 10 * solver[SOLVER_SCALE];
  if (k.iteration == 0 && k.second_guess && moved > 0 && !good) {
    solver[SOLVER_TRIAL] = 1;
    solver[SOLVER_ACTION] = 3;
    solver[SOLVER_START] = 1;
    return;
  }
  if (solver[SOLVER_TRIAL] > 0) {
    solver[SOLVER_TRIAL] = 0;
    if (!(e < solver[SOLVER_BEST] / 10)) {
      solver[SOLVER_ACTION] = 2;
      solver[SOLVER_START] = static_cast<real>(k.iteration + 1);
      return;
    }
    solver[SOLVER_FIRST] = e;
  }
  if (k.restart) {
    // Another set of contacts is another problem: its residuals are not compared with the old ones.
    solver[SOLVER_START] = static_cast<real>(k.iteration);
    if (finite) {
      solver[SOLVER_BEST] = e;
      // What momentum alone would leave is the most that a tolerance should be measured against.
      const real most = smaller(e, solver[SOLVER_SCALE]);
      solver[SOLVER_FIRST] = k.iteration == 0 ? e : larger(most, solver[SOLVER_FIRST]);
      solver[SOLVER_ITERATIONS] = static_cast<real>(k.iteration);
      solver[SOLVER_ACTION] = 1;
    }
  }
  if (!finite || e > 3 * solver[SOLVER_BEST]) {
    solver[SOLVER_ACTION] = 2;
    solver[SOLVER_RESTARTS] += 1;
    solver[SOLVER_START] = static_cast<real>(k.iteration + 1);
    solver[SOLVER_ONE_MINUS_RHO] = smaller(2 * solver[SOLVER_ONE_MINUS_RHO], real(1));
    if (solver[SOLVER_RESTARTS] >= 3)
      solver[SOLVER_GAMMA] = larger(real(0.7) * solver[SOLVER_GAMMA], real(0.1));
  } else if (e <= solver[SOLVER_BEST]) {
    solver[SOLVER_ACTION] = 1;
    solver[SOLVER_BEST] = e;
    solver[SOLVER_ITERATIONS] = static_cast<real>(k.iteration);
    // A first guess that was not finite measures nothing: its successor does.
    if (!__builtin_isfinite(solver[SOLVER_FIRST])) solver[SOLVER_FIRST] = e;
  }
  // Other contacts act: what the acceleration assumes is another problem.
  if (mark != solver[SOLVER_TOUCHED]) {
    solver[SOLVER_TOUCHED] = mark;
    solver[SOLVER_START] = static_cast<real>(k.iteration + 1);
  }
  if (finite && (e <= low || e <= k.tolerance * solver[SOLVER_FIRST])) {
    solver[SOLVER_STOP] = 1;
    solver[SOLVER_REASON] = e <= low ? real(2) : real(1);
  }
}

PLIANT_BODY(residual_control)

} // namespace pliant::openmp::PLIANT_ISA
