// Places particles by cell; see kernels/grid_place.decl.

void main() {
  uint i = thread_index();
  if (i >= threads) return;
  placed[atomicAdd(cell_next[cell_of[i]], 1u)] = i;
}
