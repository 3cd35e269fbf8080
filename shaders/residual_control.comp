// The residual and what follows from it; see kernels/residual_control.decl.
#include "common/solver.glsl"

shared vec4 group_sum[256];

// Marks modulo 1: see common/touched.glsl.
vec4 summed(vec4 a, vec4 b) {
  vec4 sum = a + b;
  if (sum.w >= 1.0) sum.w -= 1.0;
  return sum;
}

void main() {
  uint lane = gl_LocalInvocationIndex;
  vec4 sums = vec4(0.0);
  for (uint k = lane; k < partial_count; k += 256) sums = summed(sums, residual_partial[k]);
  group_sum[lane] = sums;
  barrier();
  for (uint half_width = 128; half_width > 0; half_width /= 2) {
    if (lane < half_width) group_sum[lane] = summed(group_sum[lane], group_sum[lane + half_width]);
    barrier();
  }
  if (lane != 0) return;
  if (iteration > 0 && solver[SOLVER_STOP] > 0.0) {
    solver[SOLVER_ACTION] = 0.0;
    return;
  }
  sums = group_sum[0];
  float e = sqrt(sums.x), moved = sqrt(sums.z), low = floor_residual;
  if (moved < 1e30) low = max(low, rounding * moved);
  bool finite = !isnan(e) && !isinf(e);
  if (iteration == 0) {
    solver[SOLVER_STOP] = 0.0;
    solver[SOLVER_ONE_MINUS_RHO] = one_minus_rho;
    solver[SOLVER_GAMMA] = gamma;
    solver[SOLVER_FIRST] = e;
    solver[SOLVER_BEST] = finite ? e : 3e38;
    solver[SOLVER_RESTARTS] = 0.0;
    solver[SOLVER_ITERATIONS] = 0.0;
    solver[SOLVER_REASON] = 3.0;
    solver[SOLVER_DELAY] = float(delay);
    solver[SOLVER_ACCELERATE] = float(accelerate);
    solver[SOLVER_SCALE] = sqrt(sums.y);
    solver[SOLVER_TRIAL] = 0.0;
    solver[SOLVER_TOUCHED] = sums.w;
  }
  solver[SOLVER_CURRENT] = e;
  solver[SOLVER_FLOOR] = low;
  solver[SOLVER_ACTION] = 0.0;
  if (iteration == 0 && second_guess != 0u && moved > 0.0 && !(e <= low) && !(e <= 10.0 * solver[SOLVER_SCALE])) {
    solver[SOLVER_TRIAL] = 1.0;
    solver[SOLVER_ACTION] = 3.0;
    solver[SOLVER_START] = 1.0;
    return;
  }
  if (solver[SOLVER_TRIAL] > 0.0) {
    solver[SOLVER_TRIAL] = 0.0;
    if (!(e < 0.1 * solver[SOLVER_BEST])) {
      solver[SOLVER_ACTION] = 2.0;
      solver[SOLVER_START] = float(iteration + 1);
      return;
    }
    solver[SOLVER_FIRST] = e;
  }
  if (restart != 0) {
    // Another set of contacts is another problem: its residuals are not compared with the old ones.
    solver[SOLVER_START] = float(iteration);
    if (finite) {
      solver[SOLVER_BEST] = e;
      // What momentum alone would leave is the most that a tolerance should be measured against.
      if (iteration == 0) solver[SOLVER_FIRST] = e;
      else solver[SOLVER_FIRST] = max(solver[SOLVER_FIRST], min(e, solver[SOLVER_SCALE]));
      solver[SOLVER_ITERATIONS] = float(iteration);
      solver[SOLVER_ACTION] = 1.0;
    }
  }
  if (!finite || e > 3.0 * solver[SOLVER_BEST]) {
    solver[SOLVER_ACTION] = 2.0;
    solver[SOLVER_RESTARTS] += 1.0;
    solver[SOLVER_START] = float(iteration + 1);
    solver[SOLVER_ONE_MINUS_RHO] = min(2.0 * solver[SOLVER_ONE_MINUS_RHO], 1.0);
    if (solver[SOLVER_RESTARTS] >= 3.0) solver[SOLVER_GAMMA] = max(0.7 * solver[SOLVER_GAMMA], 0.1);
  } else if (e <= solver[SOLVER_BEST]) {
    solver[SOLVER_ACTION] = 1.0;
    solver[SOLVER_BEST] = e;
    solver[SOLVER_ITERATIONS] = float(iteration);
    // A first guess that was not finite measures nothing: its successor does.
    if (isnan(solver[SOLVER_FIRST]) || isinf(solver[SOLVER_FIRST])) solver[SOLVER_FIRST] = e;
  }
  if (sums.w != solver[SOLVER_TOUCHED]) { // other contacts act: what the acceleration assumes is another problem
    solver[SOLVER_TOUCHED] = sums.w;
    solver[SOLVER_START] = float(iteration + 1);
  }
  if (finite && (e <= low || e <= tolerance * solver[SOLVER_FIRST])) {
    solver[SOLVER_STOP] = 1.0;
    solver[SOLVER_REASON] = e <= low ? 2.0 : 1.0;
  }
}
