// See kernels/coarse_solve.decl.
#include "common/solver.glsl"

shared float x[24];

void main() {
  uint lane = gl_LocalInvocationIndex, body = group_index();
  if (solver[SOLVER_LINEAR] == 0.0 || body * 32u >= threads) return; // the same for the whole group
  uint first = first_node + 8u * body, base = 576u * body;
  if (lane < 24u) x[lane] = coarse_load[first + lane / 3u][lane % 3u];
  barrier();
  for (uint k = 0u; k < 24u; ++k) {
    if (lane == k) x[k] *= factor[base + 25u * k];
    barrier();
    if (lane > k && lane < 24u) x[lane] -= factor[base + 24u * lane + k] * x[k];
    barrier();
  }
  for (uint back = 0u; back < 24u; ++back) {
    uint k = 23u - back;
    if (lane == k) x[k] *= factor[base + 25u * k];
    barrier();
    if (lane < k) x[lane] -= factor[base + 24u * k + lane] * x[k];
    barrier();
  }
  if (lane < 8u) coarse_result[first + lane] = vec4(x[3u * lane], x[3u * lane + 1u], x[3u * lane + 2u], 0.0);
}
