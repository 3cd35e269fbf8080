// See kernels/coarse_restrict.decl.
#include "common/solver.glsl"

void main() {
  uint local = thread_index();
  if (local >= threads || solver[SOLVER_LINEAR] == 0.0) return;
  uint slice = first_slice + local / 16u, lane = local % 16u;
  vec3 b = vec3(0.0);
  for (uint row = gather_begin[slice]; row < gather_begin[slice + 1u]; ++row) {
    uint entry = 16u * row + lane;
    b += gather_weight[entry] * source[gather[entry]].xyz;
  }
  uint n = first_node + local, at = n / 16u * 144u + n % 16u;
  vec3 x;
  for (int r = 0; r < 3; ++r)
    x[r] = inverse_block[at + 48u * uint(r)] * b.x + inverse_block[at + 48u * uint(r) + 16u] * b.y +
           inverse_block[at + 48u * uint(r) + 32u] * b.z;
  coarse_load[n] = vec4(b, 0.0);
  coarse_iterate[n] = vec4(relaxation * x, 0.0);
}
