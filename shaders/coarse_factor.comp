// See kernels/coarse_factor.decl.
#include "common/solver.glsl"

shared float a[24][25];

void main() {
  uint lane = gl_LocalInvocationIndex, body = group_index();
  bool works = solver[SOLVER_TAKEN] > 0.0 && solver[SOLVER_LINEAR] > 0.0 && body * 32u < threads;
  if (!works) return; // the same for the whole group
  uint first = first_node + 8u * body;
  if (lane < 24u) {
    for (uint c = 0u; c < 24u; ++c) a[lane][c] = 0.0;
    uint n = first + lane / 3u, slice = n / 16u, at = n % 16u, r = lane % 3u;
    for (uint k = 0u; k < 27u; ++k) {
      uint other = neighbour[(slice * 27u + k) * 16u + at];
      if (other == n && k != 13u) continue;
      for (uint c = 0u; c < 3u; ++c)
        a[lane][3u * (other - first) + c] = matrix[(slice * 27u + k) * 144u + 16u * (3u * r + c) + at];
    }
    a[lane][lane] *= 1.0 + 1e-5;
  }
  barrier();
  for (uint k = 0u; k < 24u; ++k) {
    float pivot = a[k][k];
    barrier();
    float inverse = pivot > 0.0 ? inversesqrt(pivot) : 0.0;
    if (lane == k) a[k][k] = inverse;
    if (lane > k && lane < 24u) a[lane][k] *= inverse;
    barrier();
    if (lane > k && lane < 24u)
      for (uint c = k + 1u; c <= lane; ++c) a[lane][c] -= a[lane][k] * a[c][k];
    barrier();
  }
  if (lane < 24u)
    for (uint c = 0u; c < 24u; ++c) factor[(body * 24u + lane) * 24u + c] = c <= lane ? a[lane][c] : 0.0;
}
