// Scans the chunks; see kernels/grid_totals.decl.
#include "common/scan.glsl"

void main() {
  uint lane = local_index(), before = 0u, total;
  for (uint first = 0u; first < chunks; first += 256u) {
    uint chunk = first + lane;
    uint sum = sum_before(chunk < chunks ? chunk_begin[chunk] : 0u, total);
    if (chunk < chunks) chunk_begin[chunk] = before + sum;
    before += total;
  }
}
