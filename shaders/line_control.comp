// See kernels/line_control.decl.
#include "common/energy_error.glsl"
#include "common/solver.glsl"

shared vec4 group_sum[256];
shared vec2 group_scale[256];

void main() {
  uint lane = gl_LocalInvocationIndex;
  vec4 sums = vec4(0.0);
  vec2 scale = vec2(0.0);
  for (uint p = lane; p < partial_count; p += 256) {
    sums += solve_partial[p];
    scale += solve_partial[partial_count + p].xy;
  }
  group_sum[lane] = sums;
  group_scale[lane] = scale;
  barrier();
  for (uint half_width = 128; half_width > 0; half_width /= 2) {
    if (lane < half_width) {
      group_sum[lane] += group_sum[lane + half_width];
      group_scale[lane] += group_scale[lane + half_width];
    }
    barrier();
  }
  if (lane != 0) return;
  sums = group_sum[0];
  solver[SOLVER_TAKEN] = 0.0;
  solver[SOLVER_ACTION] = 0.0;
  if (iteration > 0 && solver[SOLVER_STOP] > 0.0) return; // done, or nothing was evaluated
  float e = sqrt(sums.x), moved = sqrt(group_scale[0].y), low = floor_residual;
  if (moved < 1e30) low = max(low, rounding * moved);
  bool finite = !isnan(e) && !isinf(e) && !isnan(sums.y) && !isinf(sums.y);
  if (iteration == 0) {
    solver[SOLVER_COUNT] = 0.0;
    solver[SOLVER_FIRST] = e;
    solver[SOLVER_RESTARTS] = 0.0;
    solver[SOLVER_REASON] = 3.0;
    solver[SOLVER_CAUTIOUS] = 0.0;
    solver[SOLVER_RETURN] = 0.0;
    solver[SOLVER_SCALE] = sqrt(group_scale[0].x);
    solver[SOLVER_TRIAL] = 0.0;
    solver[SOLVER_CONVEX] = 0.0;
#if potential
    solver[SOLVER_RISES] = 0.0;
    solver[SOLVER_ENERGY_ERROR] = 1.0;
    solver[SOLVER_FALL] = 0.0;
    solver[SOLVER_LAST_FALL] = 0.0;
    solver[SOLVER_LEFT] = 0.0;
    solver[SOLVER_GAIN] = 0.0;
    solver[SOLVER_EXPECTED] = 0.0;
#endif
  }
  solver[SOLVER_COUNT] += 1.0;
  solver[SOLVER_CURRENT] = e;
  solver[SOLVER_FLOOR] = low;
  if (iteration == 0 && moved > 0.0 && !(e <= low) && !(e <= 10.0 * solver[SOLVER_SCALE])) {
    solver[SOLVER_TRIAL] = 1.0;
    solver[SOLVER_BEST] = finite ? e : 3e38;
    solver[SOLVER_ITERATIONS] = 0.0;
    solver[SOLVER_STOP] = 0.0;
    solver[SOLVER_LINEAR] = 0.0;
    solver[SOLVER_ACTION] = 4.0;
    return;
  }
  if (solver[SOLVER_TRIAL] > 0.0) {
    solver[SOLVER_TRIAL] = 0.0;
    solver[SOLVER_RETURN] = 1.0; // the next one evaluated, or this one, is taken
    if (!(e < 0.1 * solver[SOLVER_BEST])) {
      solver[SOLVER_ACTION] = 3.0;
      return;
    }
    solver[SOLVER_FIRST] = e;
  }
  bool taken = iteration == 0 || restart != 0u || solver[SOLVER_RETURN] > 0.0;
  float steep = sums.z / solver[SOLVER_LENGTH], slope = solver[SOLVER_SLOPE];
  bool near_floor = potential != 0 && solver[SOLVER_BEST] <= 32.0 * low;
  bool blind = false; // the precision cannot tell what the step did
  bool tried = !taken && finite;
  float fall = 0.0, rise = 0.0;
  if (tried) {
    float change = sums.y - solver[SOLVER_POTENTIAL];
    float least = noise * (abs(sums.y) + abs(solver[SOLVER_POTENTIAL])) + 64.0 * low * low;
    // A change of a few times the noise tells nothing where a fall of less than the noise is promised.
    float margin = solver[SOLVER_LENGTH] * slope < least ? 16.0 : 1.0;
    bool telling = abs(change) > margin * least;
    fall = abs(change) > 16.0 * least ? -change : 0.5 * (solver[SOLVER_LENGTH] * slope + sums.z);
    rise = change > margin * least ? 1.0 : 0.0;
#if !potential
    telling = false;
#endif
    blind = !telling;
    if (telling) taken = change <= -1e-4 * solver[SOLVER_LENGTH] * slope;
    else
      taken = (steep >= -0.8 * slope && !near_floor) || e < (1.0 - 0.25 * solver[SOLVER_LENGTH]) * solver[SOLVER_BEST];
  }
  if (taken) {
#if potential
    if (tried) {
      fall = max(fall, 0.0);
      float before = solver[SOLVER_LAST_FALL], ratio = before > 0.0 ? min(fall / before, 0.9) : 0.9;
      solver[SOLVER_RISES] += rise;
      solver[SOLVER_FALL] += fall;
      solver[SOLVER_LAST_FALL] = fall;
      solver[SOLVER_LEFT] = fall * ratio / (1.0 - ratio);
    }
#endif
    // What momentum alone would leave is the most that a tolerance should be measured against.
    if (restart != 0u && finite && iteration > 0) solver[SOLVER_FIRST] = max(solver[SOLVER_FIRST], min(e, solver[SOLVER_SCALE]));
    if (isnan(solver[SOLVER_FIRST]) || isinf(solver[SOLVER_FIRST])) solver[SOLVER_FIRST] = e;
    solver[SOLVER_TAKEN] = 1.0;
    solver[SOLVER_ACTION] = 1.0;
    solver[SOLVER_BEST] = finite ? e : 3e38;
    solver[SOLVER_POTENTIAL] = finite ? sums.y : 3e38;
    solver[SOLVER_ITERATIONS] = solver[SOLVER_COUNT] - 1.0;
    solver[SOLVER_CUTS] = 0.0;
    if (solver[SOLVER_RETURN] == 0.0) solver[SOLVER_CAUTIOUS] = 0.0;
    solver[SOLVER_RETURN] = 0.0;
    solver[SOLVER_INNER] = 0.0;
    if (e < 0.1 * solver[SOLVER_CONVEX]) solver[SOLVER_CONVEX] = 0.0; // the exact derivative is tried again
    bool enough = finite && (e <= low || e <= tolerance * solver[SOLVER_FIRST]);
    if (enough) solver[SOLVER_REASON] = e <= low ? 2.0 : 1.0;
    solver[SOLVER_STOP] = enough ? 1.0 : 0.5;
    solver[SOLVER_LINEAR] = enough ? 0.0 : 1.0;
    return;
  }
  if (blind && near_floor) { // no step lowers the residual any more
    solver[SOLVER_STOP] = 1.0;
    solver[SOLVER_REASON] = 2.0;
    return;
  }
  solver[SOLVER_CUTS] += 1.0;
  solver[SOLVER_RESTARTS] += 1.0;
  if (solver[SOLVER_COUNT] > float(cap)) {
    solver[SOLVER_STOP] = 1.0;
  } else if (solver[SOLVER_CUTS] <= 12.0) {
    float root = finite && slope > steep ? slope / (slope - steep) : 0.5;
    float factor = clamp(root, 0.1, 0.5);
    solver[SOLVER_FACTOR] = factor;
    solver[SOLVER_LENGTH] *= factor;
    solver[SOLVER_ACTION] = 2.0;
  } else if (solver[SOLVER_CAUTIOUS] == 0.0) {
    solver[SOLVER_CAUTIOUS] = 1.0;
    solver[SOLVER_RETURN] = 1.0;
    solver[SOLVER_ACTION] = 3.0;
  } else {
    solver[SOLVER_STOP] = 1.0;
    solver[SOLVER_REASON] = 4.0;
  }
}
