// Orders each cell by particle; see kernels/fluid_sort.decl. A particle's place is the number of smaller ones in its cell.

void main() {
  uint k = thread_index();
  if (k >= threads) return;
  uint i = placed[k], cell = cell_of[i], begin = cell_begin[cell], end = cell_begin[cell + 1u], place = begin;
  if (cell + 1u == cells) place = k; // what was removed is in no order: nothing looks at it
  else
    for (uint other = begin; other < end; ++other) place += placed[other] < i ? 1u : 0u;
  fluid_particle[place] = i;
}
