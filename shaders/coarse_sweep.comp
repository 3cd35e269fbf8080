// See kernels/coarse_sweep.decl.
#include "common/solver.glsl"

void main() {
  uint local = thread_index();
  if (local >= threads || solver[SOLVER_LINEAR] == 0.0) return;
  uint n = first_node + local, slice = n / 16u, lane = n % 16u;
  vec3 r = coarse_load[n].xyz;
  for (uint k = 0u; k < 27u; ++k) {
    uint at = (slice * 27u + k) * 144u + lane;
    vec3 x = coarse_iterate[neighbour[(slice * 27u + k) * 16u + lane]].xyz;
    r.x -= matrix[at] * x.x + matrix[at + 16u] * x.y + matrix[at + 32u] * x.z;
    r.y -= matrix[at + 48u] * x.x + matrix[at + 64u] * x.y + matrix[at + 80u] * x.z;
    r.z -= matrix[at + 96u] * x.x + matrix[at + 112u] * x.y + matrix[at + 128u] * x.z;
  }
#if relaxed
  uint at = slice * 144u + lane;
  vec3 x = coarse_iterate[n].xyz;
  for (int k = 0; k < 3; ++k)
    x[k] += relaxation * (inverse_block[at + 48u * uint(k)] * r.x + inverse_block[at + 48u * uint(k) + 16u] * r.y +
                          inverse_block[at + 48u * uint(k) + 32u] * r.z);
  r = x;
#endif
  coarse_result[n] = vec4(r, 0.0);
}
