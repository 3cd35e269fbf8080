// Sorting within a cell.
#pragma once

#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

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

} // namespace pliant::openmp::PLIANT_ISA
