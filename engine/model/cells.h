// Points in cells of a given size, the cells in lexicographic order: neighbour search in any extent, in O(n
// log n).
//
// Only occupied cells exist, so a particle far from the rest costs nothing. The three cells of a row along x
// are neighbours in the order, so that a cell's surroundings are nine runs of points; going through the cells
// in order, each run's ends only ever move forward.
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pliant {

/// Points sorted by cell.
struct CellGrid {
  std::vector<std::uint64_t> key;     ///< of each occupied cell, ascending: z above y above x, 21 bits each
  std::vector<std::uint32_t> first;   ///< first point of each cell in `order`; one more than there are cells
  std::vector<std::uint32_t> order;   ///< indices of the points, by cell, ascending within a cell
  std::vector<Eigen::Vector3d> point; ///< the points in that order

  /// Cells are at least `cell` wide. Throws Error(usage) where a point is not finite.
  CellGrid(const std::vector<Eigen::Vector3d>& points, double cell);
  std::size_t cells() const { return key.size(); }
};

/// A run of points in CellGrid::order: [first, last).
struct CellRun {
  std::uint32_t first = 0, last = 0;
};

/// The nine runs that surround a cell; call with ascending cells.
class CellWalk {
public:
  CellWalk(const CellGrid& grid, std::size_t start);
  const std::array<CellRun, 9>& at(std::size_t cell);

private:
  const CellGrid& grid_;
  std::array<std::size_t, 9> low_{}, high_{};
  std::array<CellRun, 9> runs_{};
};

} // namespace pliant
