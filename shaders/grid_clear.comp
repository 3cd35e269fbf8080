// Empties the grid; see kernels/grid_clear.decl.

void main() {
  uint cell = thread_index();
  if (cell < threads) cell_count[cell] = 0u;
  if (cell < 2u) left_out[cell] = 0u;
}
