// Scans the cells of a chunk; see kernels/grid_scan.decl.
#include "common/contact.glsl"
#include "common/scan.glsl"

void main() {
  uint chunk = group_index(), total;
  bool mine = chunk < group_count();
  uint before = mine ? chunk_begin[chunk] : 0u;
  for (uint first = 0u; first < SCAN_CHUNK; first += 256u) {
    uint cell = SCAN_CHUNK * chunk + first + local_index();
    bool real_cell = mine && cell < cells;
    uint count = real_cell ? cell_count[cell] : 0u;
    uint begin = before + sum_before(count, total);
    if (real_cell) {
      cell_count[cell] = begin;
      cell_begin[cell] = begin;
      if (cell + 1u == cells) cell_begin[cells] = begin + count;
    }
    before += total;
  }
}
