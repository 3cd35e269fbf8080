// See kernels/history_control.decl.
#include "common/energy_error.glsl"
#include "common/solver.glsl"

shared float group_sum[128];
#if remembers
shared float total[HISTORY_DOTS];
#endif

void main() {
  uint lane = gl_LocalInvocationIndex;
  float sum = 0.0;
  for (uint p = lane; p < partial_count; p += 128u) sum += solve_partial[p].x;
  group_sum[lane] = sum;
#if remembers
  if (lane < uint(HISTORY_DOTS)) {
    float dots = 0.0;
    for (uint p = 0u; p < partial_count; ++p) dots += history_partial[uint(HISTORY_DOTS) * p + lane];
    total[lane] = dots;
  }
#endif
  barrier();
  for (uint half_width = 64; half_width > 0; half_width /= 2) {
    if (lane < half_width) group_sum[lane] += group_sum[lane + half_width];
    barrier();
  }
  if (lane != 0u) return;
  solver[SOLVER_ACTION] = 0.0;
  if (solver[SOLVER_LINEAR] == 0.0) return;
  float rz = group_sum[0];
  if (!(rz > 0.0) || isinf(rz)) { // the residual is zero, or no number
    solver[SOLVER_LINEAR] = 0.0;
    solver[SOLVER_STOP] = 1.0;
    solver[SOLVER_REASON] = 4.0;
    return;
  }
  solver[SOLVER_KEEP_Z] = 1.0;
  solver[SOLVER_SLOPE] = first_length * rz;
  solver[SOLVER_LENGTH] = 1.0;
#if remembers
  uint newest = (uint(solver[SOLVER_NEWEST]) + 1u) % uint(MEMORY), count = uint(solver[SOLVER_HISTORY]);
  for (uint i = 0u; i < uint(MEMORY); ++i) {
    gram[5u * i + newest] = total[5u * i + 2u];
    gram[5u * newest + i] = total[5u * i + 3u];
    gram[25u + 5u * i + newest] = total[5u * i + 4u];
    gram[25u + 5u * newest + i] = total[5u * i + 4u];
  }
  float sy = gram[6u * newest], yz = gram[25u + 6u * newest];
  bool good = forget == 0u && solver[SOLVER_CAUTIOUS] == 0.0 && sy > 0.0 && yz > 0.0 && !isinf(sy) && !isinf(yz);
  if (forget != 0u || solver[SOLVER_CAUTIOUS] > 0.0) count = 0u;
  if (good) {
    solver[SOLVER_NEWEST] = float(newest);
    count = min(count + 1u, uint(MEMORY));
  } else {
    count = min(count, uint(MEMORY) - 1u); // the slot was the oldest one's
  }
  uint last = uint(solver[SOLVER_NEWEST]);
  if (count > 0u) {
    float gamma = clamp(gram[6u * last] / gram[25u + 6u * last], 0.02, largest_scale);
    float alpha[MEMORY], on_step[MEMORY];
    for (uint a = 0u; a < count; ++a) { // newest first
      uint i = (last + uint(MEMORY) - a) % uint(MEMORY);
      float value = total[5u * i];
      for (uint b = 0u; b < a; ++b) {
        uint j = (last + uint(MEMORY) - b) % uint(MEMORY);
        value -= alpha[j] * gram[5u * i + j];
      }
      alpha[i] = value / gram[6u * i];
    }
    for (uint back = 0u; back < count; ++back) { // oldest first
      uint a = count - 1u - back, i = (last + uint(MEMORY) - a) % uint(MEMORY);
      float value = total[5u * i + 1u];
      for (uint b = 0u; b < count; ++b) {
        uint j = (last + uint(MEMORY) - b) % uint(MEMORY);
        value -= alpha[j] * gram[25u + 5u * i + j];
      }
      value *= gamma;
      for (uint b = a + 1u; b < count; ++b) {
        uint j = (last + uint(MEMORY) - b) % uint(MEMORY);
        value += on_step[j] * gram[5u * j + i];
      }
      on_step[i] = alpha[i] - value / gram[6u * i];
    }
    float slope = gamma * rz;
    for (uint a = 0u; a < count; ++a) {
      uint i = (last + uint(MEMORY) - a) % uint(MEMORY);
      slope += on_step[i] * total[5u * i] - gamma * alpha[i] * total[5u * i + 1u];
      solver[SOLVER_KEEP_STEP + i] = on_step[i];
      solver[SOLVER_KEEP_IMAGE + i] = -gamma * alpha[i];
    }
    if (slope > 0.0 && !isinf(slope)) {
      solver[SOLVER_KEEP_Z] = gamma;
      solver[SOLVER_SLOPE] = slope;
      solver[SOLVER_LENGTH] = 1.0;
    } else {
      count = 0u;
    }
  }
  if (count == 0u)
    for (uint i = 0u; i < uint(MEMORY); ++i) solver[SOLVER_KEEP_STEP + i] = solver[SOLVER_KEEP_IMAGE + i] = 0.0;
  solver[SOLVER_HISTORY] = float(count);
  if (count == 0u) solver[SOLVER_KEEP_Z] = first_length;
#else
  solver[SOLVER_KEEP_Z] = first_length;
#endif
  solver[SOLVER_LINEAR] = 0.0;
  if (energy_tolerance > 0.0 && solver[SOLVER_FALL] > 0.0) {
    float forgotten = clamp(16.0 / max(solver[SOLVER_COUNT] - 1.0, 1.0), 0.25, 1.0);
    float left = max(2.5 * max(0.5 * solver[SOLVER_SLOPE], solver[SOLVER_LEFT]), (1.0 - forgotten) * solver[SOLVER_EXPECTED]);
    solver[SOLVER_EXPECTED] = left;
    float error = left / (solver[SOLVER_FALL] + left);
    solver[SOLVER_ENERGY_ERROR] = error;
    if (error <= energy_tolerance) {
      solver[SOLVER_STOP] = 1.0;
      solver[SOLVER_REASON] = 1.0;
      return;
    }
  }
  solver[SOLVER_ACTION] = 1.0;
  solver[SOLVER_STOP] = 0.0;
}
