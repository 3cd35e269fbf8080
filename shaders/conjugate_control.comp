// See kernels/conjugate_control.decl.
#include "common/energy_error.glsl"
#include "common/solver.glsl"

shared vec4 group_sum[256];

// The direction is complete: the next iteration evaluates the end of the whole step.
void complete() {
  solver[SOLVER_LINEAR] = 0.0;
  solver[SOLVER_STOP] = 0.0;
  solver[SOLVER_LENGTH] = 1.0;
}

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
  solver[SOLVER_ACTION] = 0.0;
  if (solver[SOLVER_LINEAR] == 0.0) return;
  float found = sums.x;
#if after
  float rz = solver[SOLVER_RZ];
  solver[SOLVER_COUNT] += 1.0;
  bool first = solver[SOLVER_INNER] == 0.0;
  if (!(found > 0.0) || isinf(found)) {
    solver[SOLVER_CONVEX] = solver[SOLVER_BEST];
    solver[SOLVER_CG_STEP] = first ? 1.0 : 0.0;
    if (first) solver[SOLVER_SLOPE] = rz;
    solver[SOLVER_ACTION] = 2.0;
    complete();
    return;
  }
  solver[SOLVER_CG_STEP] = rz / found;
  solver[SOLVER_SLOPE] += solver[SOLVER_CG_STEP] * rz; // r_first . p = r . z along conjugate directions
  solver[SOLVER_INNER] += 1.0;
  if (energy_tolerance > 0.0)
    solver[SOLVER_GAIN] = max(max(solver[SOLVER_GAIN], solver[SOLVER_CG_STEP]), solver[SOLVER_SLOPE] / solver[SOLVER_RZ_FIRST]);
  bool end = solver[SOLVER_COUNT] >= float(cap) || solver[SOLVER_CAUTIOUS] > 0.0;
  solver[SOLVER_ACTION] = end ? 2.0 : 1.0;
  if (end) complete();
#else
  float keep = 0.0;
  if (solver[SOLVER_INNER] == 0.0) {
    bool exhausted = solver[SOLVER_COUNT] >= float(cap);
    if (exhausted || !(found > 0.0) || isinf(found)) { // or the residual is zero, or no number
      solver[SOLVER_LINEAR] = 0.0;
      solver[SOLVER_STOP] = 1.0;
      solver[SOLVER_REASON] = exhausted ? 3.0 : 4.0;
      return;
    }
    if (energy_tolerance > 0.0) {
      float left = solver[SOLVER_GAIN] * found;
      if (left > 0.0 && solver[SOLVER_FALL] > 0.0) {
        float error = left / (solver[SOLVER_FALL] + left);
        solver[SOLVER_ENERGY_ERROR] = error;
        if (error <= energy_tolerance) {
          solver[SOLVER_LINEAR] = 0.0;
          solver[SOLVER_STOP] = 1.0;
          solver[SOLVER_REASON] = 1.0;
          return;
        }
      }
      solver[SOLVER_RZ_FIRST] = found;
    }
    float forcing = min(0.1, sqrt(solver[SOLVER_BEST] / solver[SOLVER_FIRST]));
    solver[SOLVER_RZ_ENOUGH] = forcing * forcing * found;
    solver[SOLVER_SLOPE] = 0.0;
  } else {
    float enough = energy_tolerance * (solver[SOLVER_FALL] + 0.5 * solver[SOLVER_SLOPE]);
    bool close = energy_tolerance > 0.0 && 2.0 * solver[SOLVER_GAIN] * found <= enough;
    if (!(found > solver[SOLVER_RZ_ENOUGH]) || close || solver[SOLVER_COUNT] >= float(cap)) {
      solver[SOLVER_ACTION] = 2.0;
      complete();
      return;
    }
    keep = found / solver[SOLVER_RZ];
  }
  solver[SOLVER_CG_KEEP] = keep;
  solver[SOLVER_RZ] = found;
  solver[SOLVER_ACTION] = 1.0;
#endif
}
