// Orders each cell by particle; see kernels/grid_sort.decl.
#include "kernels/grid_sort.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

namespace {

// Insertion for cells as they are, a heap for a crowd.
PLIANT_INLINE void sink(uint* __restrict heap, uint at, uint count) {
  const uint value = heap[at];
  for (uint child = 2 * at + 1; child < count; child = 2 * at + 1) {
    if (child + 1 < count && heap[child + 1] > heap[child]) ++child;
    if (heap[child] <= value) break;
    heap[at] = heap[child];
    at = child;
  }
  heap[at] = value;
}

PLIANT_INLINE void sort(uint* __restrict values, uint count) {
  if (count <= 32) {
    for (uint a = 1; a < count; ++a) {
      const uint value = values[a];
      uint at = a;
      for (; at > 0 && values[at - 1] > value; --at) values[at] = values[at - 1];
      values[at] = value;
    }
    return;
  }
  for (uint a = count / 2; a > 0; --a) sink(values, a - 1, count);
  for (uint last = count - 1; last > 0; --last) {
    const uint largest = values[0];
    values[0] = values[last];
    sink(values, 0, last);
    values[last] = largest;
  }
}

} // namespace

template <class real> void grid_sort(const kernels::grid_sort::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint cell = 0; cell < k.cells; ++cell) {
    const uint begin = k.cell_begin[cell], end = k.cell_begin[cell + 1];
    for (uint place = begin; place < end; ++place) k.sorted[place] = k.placed[place];
    sort(k.sorted + begin, end - begin);
    for (uint place = begin; place < end; ++place) {
      const uint i = k.sorted[place];
      const Vec3<real> x = xyz(k.start[i]) + xyz(k.displacement[i]);
      k.sorted_place[place] = {x.x, x.y, x.z, static_cast<real>(k.owner[i])};
    }
  }
}

PLIANT_BODY(grid_sort)

} // namespace pliant::openmp::PLIANT_ISA
