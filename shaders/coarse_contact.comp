// See kernels/coarse_contact.decl.
#include "common/solver.glsl"

void main() {
  uint local = thread_index();
  if (local >= threads || solver[SOLVER_TAKEN] == 0.0 || solver[SOLVER_LINEAR] == 0.0) return;
  uint slice = first_slice + local / 16u, lane = local % 16u;
  vec4 a = vec4(0.0), b = vec4(0.0);
  for (uint row = gather_begin[slice]; row < gather_begin[slice + 1u]; ++row) {
    uint entry = 16u * row + lane, from = gather[entry];
    float w = gather_weight[entry];
#if particles
    a += w * contact_block[2u * from];
    b += w * contact_block[2u * from + 1u];
#else
    a += w * coarse_block[2u * from];
    b += w * coarse_block[2u * from + 1u];
#endif
  }
  uint n = first_node + local;
  coarse_block[2u * n] = a;
  coarse_block[2u * n + 1u] = b;
}
