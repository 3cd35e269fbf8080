// Hashed cells of the particle grid: the number of a cell is the hash of its y and z, plus its x.
#pragma once

#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

struct Cell {
  int x, y, z;
};

/// The largest whole number not above x per_cell; 0 for what is lost or not finite.
template <class real> PLIANT_INLINE int cell_coordinate(real x, real per_cell) {
  const real at = x * per_cell;
  if (!(at > real(-1e9) && at < real(1e9))) return 0;
  const int cut = static_cast<int>(at);
  return static_cast<real>(cut) > at ? cut - 1 : cut;
}

template <class real> PLIANT_INLINE Cell cell_at(Vec3<real> x, real per_cell) {
  return {cell_coordinate(x.x, per_cell), cell_coordinate(x.y, per_cell), cell_coordinate(x.z, per_cell)};
}

PLIANT_INLINE uint row_hash(int y, int z) {
  uint h = (static_cast<uint>(y) * 2654435761u) ^ (static_cast<uint>(z) * 2246822519u);
  h ^= h >> 15;
  h *= 739982445u;
  return h ^ (h >> 12);
}

PLIANT_INLINE uint cell_number(Cell cell, uint mask) {
  return (row_hash(cell.y, cell.z) + static_cast<uint>(cell.x)) & mask;
}

} // namespace pliant::openmp::PLIANT_ISA
