// See kernels/line_control.decl.
#include "common/solver.glsl"

shared vec4 group_sum[256];

void main() {
  uint lane = gl_LocalInvocationIndex;
  vec4 sums = vec4(0.0);
  for (uint p = lane; p < partial_count; p += 256) sums += solve_partial[p];
  group_sum[lane] = sums;
  barrier();
  for (uint half_width = 128; half_width > 0; half_width /= 2) {
    if (lane < half_width) group_sum[lane] += group_sum[lane + half_width];
    barrier();
  }
  if (lane != 0) return;
  sums = group_sum[0];
  solver[SOLVER_TAKEN] = 0.0;
  solver[SOLVER_ACTION] = 0.0;
  if (iteration > 0 && solver[SOLVER_STOP] > 0.0) return; // done, or nothing was evaluated
  float e = sqrt(sums.x);
  bool finite = !isnan(e) && !isinf(e) && !isnan(sums.y) && !isinf(sums.y);
  if (iteration == 0) {
    solver[SOLVER_COUNT] = 0.0;
    solver[SOLVER_FIRST] = e;
    solver[SOLVER_RESTARTS] = 0.0;
    solver[SOLVER_REASON] = 3.0;
    solver[SOLVER_CAUTIOUS] = 0.0;
    solver[SOLVER_RETURN] = 0.0;
  }
  solver[SOLVER_COUNT] += 1.0;
  solver[SOLVER_CURRENT] = e;
  bool taken = iteration == 0 || restart != 0u || solver[SOLVER_RETURN] > 0.0;
  float steep = sums.z / solver[SOLVER_LENGTH], slope = solver[SOLVER_SLOPE];
  if (!taken && finite) {
    float change = sums.y - solver[SOLVER_POTENTIAL];
    bool telling = abs(change) > noise * (abs(sums.y) + abs(solver[SOLVER_POTENTIAL]));
#if !potential
    telling = false;
#endif
    if (telling) taken = change <= -1e-4 * solver[SOLVER_LENGTH] * slope;
    else taken = steep >= -0.8 * slope || e < (1.0 - 0.25 * solver[SOLVER_LENGTH]) * solver[SOLVER_BEST];
  }
  if (taken) {
    if (restart != 0u && finite) solver[SOLVER_FIRST] = max(e, solver[SOLVER_FIRST]);
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
    bool enough = finite && (e <= floor_residual || e <= tolerance * solver[SOLVER_FIRST]);
    if (enough) solver[SOLVER_REASON] = e <= floor_residual ? 2.0 : 1.0;
    solver[SOLVER_STOP] = enough ? 1.0 : 0.5;
    solver[SOLVER_LINEAR] = enough ? 0.0 : 1.0;
    return;
  }
  solver[SOLVER_CUTS] += 1.0;
  solver[SOLVER_RESTARTS] += 1.0;
  if (solver[SOLVER_CUTS] <= 12.0) {
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
