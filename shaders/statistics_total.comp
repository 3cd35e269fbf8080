// One row for the step; see kernels/statistics_total.decl.
#include "common/solver.glsl"
#include "common/group_sum.glsl"

shared vec2 group_largest[128];

void main() {
  uint lane = gl_LocalInvocationIndex;
  vec4 energies = vec4(0.0), momentum = vec4(0.0);
  vec2 largest = vec2(0.0);
  for (uint k = lane; k < chunk_count; k += 128) {
    energies += vec4(chunk_sum[2 * k].xy, 0.0, chunk_sum[2 * k].w);
    momentum.xyz += chunk_sum[2 * k + 1].xyz;
    largest = max(largest, vec2(chunk_sum[2 * k].z, chunk_sum[2 * k + 1].w));
  }
  energies = sum_over_group(energies);
  momentum = sum_over_group(momentum);
  group_largest[lane] = largest;
  barrier();
  for (uint half_width = 64; half_width > 0; half_width /= 2) {
    if (lane < half_width) group_largest[lane] = max(group_largest[lane], group_largest[lane + half_width]);
    barrier();
  }
  if (lane != 0) return;
  uint base = 16 * row;
  statistics[base] = energies.x;
  statistics[base + 1] = energies.y;
  statistics[base + 2] = sqrt(group_largest[0].x);
  statistics[base + 3] = energies.w;
  statistics[base + 4] = momentum.x;
  statistics[base + 5] = momentum.y;
  statistics[base + 6] = momentum.z;
  statistics[base + 7] = sqrt(group_largest[0].y);
  statistics[base + 8] = solver[SOLVER_FIRST];
  statistics[base + 9] = solver[SOLVER_BEST];
  statistics[base + 10] = solver[SOLVER_FLOOR];
  statistics[base + 11] = solver[SOLVER_ITERATIONS];
  statistics[base + 12] = solver[SOLVER_RESTARTS];
  statistics[base + 13] = solver[SOLVER_REASON];
  statistics[base + 14] = solver[SOLVER_ONE_MINUS_RHO];
  statistics[base + 15] = solver[SOLVER_GAMMA];
}
