// See kernels/conjugate_control.decl.
#include "common/energy_error.glsl"
#include "common/solver.glsl"
#include "common/trust_region.glsl"

shared vec4 group_sum[256];

// The direction is complete: the next iteration evaluates the end of the whole step.
void complete() {
  solver[SOLVER_LINEAR] = 0.0;
  solver[SOLVER_STOP] = 0.0;
  solver[SOLVER_LENGTH] = 1.0;
  if (solver[SOLVER_EDGE] == 0.0) solver[SOLVER_EDGE] = 1.0;
}

// The region's size, from how well the last step did.
void choose_radius() {
  float edge = solver[SOLVER_EDGE], norm = sqrt(solver[SOLVER_STEP2]);
  float worth = potential > 0 ? solver[SOLVER_LAST_FALL] : solver[SOLVER_PROMISE];
  solver[SOLVER_EDGE] = 0.0;
  if (solver[SOLVER_CAUTIOUS] > 0.0) {
    solver[SOLVER_RADIUS] = 0.0;
    return;
  }
  if (edge == 0.0) return;
  if (solver[SOLVER_LENGTH] < 1.0)
    solver[SOLVER_RADIUS] = solver[SOLVER_LENGTH] * norm;
  else if (worth < TRUST_LEAST * solver[SOLVER_PROMISE])
    solver[SOLVER_RADIUS] = 0.5 * norm;
  else if (edge == 2.0 && !(worth < TRUST_MOST * solver[SOLVER_PROMISE]))
    solver[SOLVER_RADIUS] = 2.0 * solver[SOLVER_RADIUS];
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
  bool first = solver[SOLVER_INNER] == 0.0, positive = found > 0.0 && !isinf(found);
  float way = 0.0; // t > 0 with |d + t p| = radius
  bool bounded = solver[SOLVER_RADIUS] > 0.0 && !isinf(found) && !isnan(found);
  if (bounded) {
    float radius = solver[SOLVER_RADIUS], along = solver[SOLVER_STEP_ALONG];
    float left = max(radius * radius - solver[SOLVER_STEP2], 0.0);
    float below = along + sqrt(max(along * along + solver[SOLVER_DIRECTION2] * left, 0.0));
    if (below > 0.0) way = left / below;
  }
  if (bounded && (!positive || rz / found >= way)) {
    float step = rz / found;
    if (positive && energy_tolerance > 0.0) {
      float share = (solver[SOLVER_SLOPE] + step * rz) / solver[SOLVER_RZ_FIRST];
      solver[SOLVER_GAIN] = max(max(solver[SOLVER_GAIN], step), share);
    }
    solver[SOLVER_CG_STEP] = way;
    solver[SOLVER_SLOPE] += way * rz;
    solver[SOLVER_PROMISE] += way * (rz - 0.5 * way * found);
    solver[SOLVER_STEP2] = solver[SOLVER_RADIUS] * solver[SOLVER_RADIUS];
    solver[SOLVER_INNER] += 1.0;
    solver[SOLVER_EDGE] = 2.0;
    solver[SOLVER_ACTION] = 2.0;
    complete();
    return;
  }
  if (!positive) {
    solver[SOLVER_CONVEX] = solver[SOLVER_BEST];
    solver[SOLVER_CG_STEP] = first ? 1.0 : 0.0;
    if (first) {
      solver[SOLVER_SLOPE] = rz;
      solver[SOLVER_PROMISE] = rz;
      solver[SOLVER_STEP2] = solver[SOLVER_DIRECTION2];
    }
    solver[SOLVER_ACTION] = 2.0;
    complete();
    return;
  }
  solver[SOLVER_CG_STEP] = rz / found;
  float step = solver[SOLVER_CG_STEP];
  solver[SOLVER_STEP2] += step * (2.0 * solver[SOLVER_STEP_ALONG] + step * solver[SOLVER_DIRECTION2]);
  solver[SOLVER_PROMISE] += 0.5 * step * rz;
  solver[SOLVER_SLOPE] += step * rz; // r_first . p = r . z along conjugate directions
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
    choose_radius();
    solver[SOLVER_STEP2] = 0.0;
    solver[SOLVER_STEP_ALONG] = 0.0;
    solver[SOLVER_PROMISE] = 0.0;
    solver[SOLVER_DIRECTION2] = found;
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
    float along = solver[SOLVER_STEP_ALONG] + solver[SOLVER_CG_STEP] * solver[SOLVER_DIRECTION2];
    solver[SOLVER_STEP_ALONG] = keep * along;
    solver[SOLVER_DIRECTION2] = found + keep * keep * solver[SOLVER_DIRECTION2];
  }
  solver[SOLVER_CG_KEEP] = keep;
  solver[SOLVER_RZ] = found;
  solver[SOLVER_ACTION] = 1.0;
#endif
}
