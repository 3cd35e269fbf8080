// Sums chunks of cells; see kernels/grid_sum.decl.
#include "common/contact.glsl"

shared uint group_sum[256];

void main() {
  uint lane = local_index(), chunk = group_index(), sum = 0u;
  for (uint k = lane; k < SCAN_CHUNK; k += 256u) {
    uint cell = SCAN_CHUNK * chunk + k;
    if (cell < cells) sum += cell_count[cell];
  }
  group_sum[lane] = sum;
  barrier();
  for (uint half_width = 128u; half_width > 0u; half_width /= 2u) {
    if (lane < half_width) group_sum[lane] += group_sum[lane + half_width];
    barrier();
  }
  if (lane == 0u && chunk < group_count()) chunk_begin[chunk] = group_sum[0];
}
