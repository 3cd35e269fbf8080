// See kernels/line_control.decl.
#include "kernels/line_control.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"
#include "shaders/common/energy_error.glsl"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void line_control(const kernels::line_control::View<real>& k) {
  Real4<real> sums{0, 0, 0, 0};
  real impulse = 0, displaced = 0;
  for (uint p = 0; p < k.partial_count; ++p) {
    const auto part = k.solve_partial[p];
    sums = {sums.x + part.x, sums.y + part.y, sums.z + part.z, sums.w + part.w};
    impulse += k.solve_partial[k.partial_count + p].x;
    displaced += k.solve_partial[k.partial_count + p].y;
  }
  real* const solver = k.solver;
  solver[SOLVER_TAKEN] = 0;
  solver[SOLVER_ACTION] = 0;
  if (k.iteration > 0 && solver[SOLVER_STOP] > 0) return; // done, or nothing was evaluated
  const real e = root(sums.x), phi = sums.y, moved = root(displaced);
  const real low = moved < real(1e30) ? larger(k.floor_residual, k.rounding * moved) : k.floor_residual;
  const bool finite = __builtin_isfinite(e) && __builtin_isfinite(phi);
  if (k.iteration == 0) {
    solver[SOLVER_COUNT] = 0;
    solver[SOLVER_FIRST] = e;
    solver[SOLVER_RESTARTS] = 0;
    solver[SOLVER_REASON] = 3;
    solver[SOLVER_CAUTIOUS] = 0;
    solver[SOLVER_RETURN] = 0;
    solver[SOLVER_SCALE] = root(impulse);
    solver[SOLVER_TRIAL] = 0;
    solver[SOLVER_CONVEX] = 0;
    if (k.potential) {
      solver[SOLVER_RISES] = 0;
      solver[SOLVER_ENERGY_ERROR] = 1;
      solver[SOLVER_FALL] = solver[SOLVER_LAST_FALL] = solver[SOLVER_LEFT] = solver[SOLVER_GAIN] = 0;
      solver[SOLVER_EXPECTED] = 0;
    }
  }
  solver[SOLVER_COUNT] += 1;
  solver[SOLVER_CURRENT] = e;
  solver[SOLVER_FLOOR] = low;
  const bool good = e <= low || e <= 10 * solver[SOLVER_SCALE];
  if (k.iteration == 0 && moved > 0 && !good) {
    solver[SOLVER_TRIAL] = 1;
    solver[SOLVER_BEST] = finite ? e : real(3e38);
    solver[SOLVER_ITERATIONS] = 0;
    solver[SOLVER_STOP] = 0;
    solver[SOLVER_LINEAR] = 0;
    solver[SOLVER_ACTION] = 4;
    return;
  }
  if (solver[SOLVER_TRIAL] > 0) {
    solver[SOLVER_TRIAL] = 0;
    solver[SOLVER_RETURN] = 1; // the next one evaluated, or this one, is taken
    if (!(e < solver[SOLVER_BEST] / 10)) {
      solver[SOLVER_ACTION] = 3;
      return;
    }
    solver[SOLVER_FIRST] = e;
  }
  const real length = solver[SOLVER_LENGTH], slope = solver[SOLVER_SLOPE], steep = sums.z / length;
  bool taken = k.iteration == 0 || k.restart || solver[SOLVER_RETURN] > 0;
  const bool near_floor = k.potential && solver[SOLVER_BEST] <= 32 * low;
  bool blind = false; // the precision cannot tell what the step did
  real fall = 0, rise = 0;
  const bool tried = !taken && finite;
  if (tried) {
    const real before = solver[SOLVER_POTENTIAL], change = phi - before;
    const real least = k.noise * (magnitude(phi) + magnitude(before)) + 64 * low * low;
    // Where less than the noise is promised, a change of a few times that is noise.
    const real telling = length * slope < least ? 16 * least : least;
    rise = change > telling ? real(1) : real(0);
    fall = magnitude(change) > 16 * least ? -change : (length * slope + sums.z) / 2;
    blind = !k.potential || !(magnitude(change) > telling);
    if (!blind)
      taken = change <= real(-1e-4) * length * slope;
    else
      taken = (steep >= real(-0.8) * slope && !near_floor) || e < (1 - length / 4) * solver[SOLVER_BEST];
  }
  if (taken) {
    if (k.potential && tried) {
      solver[SOLVER_RISES] += rise;
      fall = larger(fall, real(0));
      const real last = solver[SOLVER_LAST_FALL];
      // A first step tells nothing of the next.
      const real ratio = last > 0 ? smaller(fall / last, real(0.9)) : real(0.9);
      solver[SOLVER_FALL] += fall;
      solver[SOLVER_LAST_FALL] = fall;
      solver[SOLVER_LEFT] = fall * ratio / (1 - ratio);
    }
    // What momentum alone would leave is the most that a tolerance should be measured against.
    const real most = smaller(e, solver[SOLVER_SCALE]);
    if (k.restart && finite && k.iteration > 0) solver[SOLVER_FIRST] = larger(most, solver[SOLVER_FIRST]);
    if (!__builtin_isfinite(solver[SOLVER_FIRST])) solver[SOLVER_FIRST] = e;
    const bool enough = finite && (e <= low || e <= k.tolerance * solver[SOLVER_FIRST]);
    solver[SOLVER_TAKEN] = 1;
    solver[SOLVER_ACTION] = 1;
    solver[SOLVER_BEST] = finite ? e : real(3e38);
    solver[SOLVER_POTENTIAL] = finite ? phi : real(3e38);
    solver[SOLVER_ITERATIONS] = solver[SOLVER_COUNT] - 1;
    solver[SOLVER_CUTS] = 0;
    if (solver[SOLVER_RETURN] == 0) solver[SOLVER_CAUTIOUS] = 0;
    solver[SOLVER_RETURN] = 0;
    solver[SOLVER_INNER] = 0;
    if (e < solver[SOLVER_CONVEX] / 10) solver[SOLVER_CONVEX] = 0; // the exact derivative is tried again
    if (enough) solver[SOLVER_REASON] = e <= low ? real(2) : real(1);
    solver[SOLVER_STOP] = enough ? real(1) : real(0.5);
    solver[SOLVER_LINEAR] = enough ? real(0) : real(1);
    return;
  }
  if (blind && near_floor) { // no step lowers the residual any more
    solver[SOLVER_STOP] = 1;
    solver[SOLVER_REASON] = 2;
    return;
  }
  solver[SOLVER_CUTS] += 1;
  solver[SOLVER_RESTARTS] += 1;
  if (solver[SOLVER_COUNT] > static_cast<real>(k.cap)) {
    solver[SOLVER_STOP] = 1;
  } else if (solver[SOLVER_CUTS] <= 12) {
    const real root_of_secant = finite && slope > steep ? slope / (slope - steep) : real(0.5);
    const real factor = larger(real(0.1), smaller(real(0.5), root_of_secant));
    solver[SOLVER_FACTOR] = factor;
    solver[SOLVER_LENGTH] = length * factor;
    solver[SOLVER_ACTION] = 2;
  } else if (solver[SOLVER_CAUTIOUS] == 0) {
    solver[SOLVER_CAUTIOUS] = 1;
    solver[SOLVER_RETURN] = 1;
    solver[SOLVER_ACTION] = 3;
  } else {
    solver[SOLVER_STOP] = 1;
    solver[SOLVER_REASON] = 4;
  }
}

PLIANT_BODY(line_control)

} // namespace pliant::openmp::PLIANT_ISA
