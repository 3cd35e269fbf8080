// Counts particles by cell; see kernels/grid_count.decl.
#include "common/cells.glsl"

void main() {
  uint i = thread_index();
  if (i >= threads) return;
  uint cell = cell_number(cell_at(start[i].xyz + displacement[i].xyz, per_cell), mask);
  cell_of[i] = cell;
  atomicAdd(cell_count[cell], 1u);
}
