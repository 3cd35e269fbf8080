// Orders each cell by particle; see kernels/grid_sort.decl. A particle's place is the number of smaller ones in its cell.

void main() {
  uint k = thread_index();
  if (k >= threads) return;
  uint i = placed[k], cell = cell_of[i], begin = cell_begin[cell], end = cell_begin[cell + 1u], place = begin;
  for (uint other = begin; other < end; ++other) place += placed[other] < i ? 1u : 0u;
  sorted[place] = i;
  sorted_place[place] = vec4(start[i].xyz + displacement[i].xyz, float(owner[i]));
}
