// Sorting points into cells, and walking through them.
#include "engine/model/cells.h"

#include "engine/core/error.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace pliant {

namespace {

constexpr int axis_bits = 21;
/// Cells along an axis at most; beyond that they grow. Leaves room for the neighbour on either side.
constexpr double axis_cells = 1 << 20;

/// Step of the key to the row of cells at (dy, dz), row = 3 (dz + 1) + dy + 1.
std::int64_t row_step(std::size_t row) {
  const auto dy = static_cast<std::int64_t>(row % 3) - 1;
  const auto dz = static_cast<std::int64_t>(row / 3) - 1;
  return dz * (std::int64_t{1} << (2 * axis_bits)) + dy * (std::int64_t{1} << axis_bits);
}

std::uint64_t row_key(std::uint64_t key, std::size_t row) {
  return static_cast<std::uint64_t>(static_cast<std::int64_t>(key) + row_step(row));
}

} // namespace

CellGrid::CellGrid(const std::vector<Eigen::Vector3d>& points, double cell) {
  if (points.size() >= UINT32_MAX)
    throw Error(ExitCode::too_large,
                fmt::format("{} particles are more than 32 bits can count", points.size()));
  if (points.empty()) {
    first.push_back(0);
    return;
  }
  Eigen::Vector3d low = points[0], high = points[0];
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite())
      throw Error(ExitCode::usage, fmt::format("the position of particle {} is not finite ({}, {}, {})", i,
                                               points[i].x(), points[i].y(), points[i].z()));
    low = low.cwiseMin(points[i]);
    high = high.cwiseMax(points[i]);
  }
  // A little wider than asked, so that rounding never puts two points within reach two cells apart.
  const double width = std::max(cell * (1 + 1e-9), (high - low).maxCoeff() / axis_cells);
  struct Entry {
    std::uint64_t key;
    std::uint32_t index;
  };
  std::vector<Entry> entries(points.size());
#pragma omp parallel for schedule(static)
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::uint64_t k = 0;
    for (int axis = 2; axis >= 0; --axis)
      k = (k << axis_bits) | (static_cast<std::uint64_t>((points[i][axis] - low[axis]) / width) + 1);
    entries[i] = {k, static_cast<std::uint32_t>(i)};
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.key != b.key ? a.key < b.key : a.index < b.index;
  });
  order.resize(points.size());
  point.resize(points.size());
  for (std::size_t s = 0; s < entries.size(); ++s) {
    if (s == 0 || entries[s].key != entries[s - 1].key) {
      key.push_back(entries[s].key);
      first.push_back(static_cast<std::uint32_t>(s));
    }
    order[s] = entries[s].index;
    point[s] = points[entries[s].index];
  }
  first.push_back(static_cast<std::uint32_t>(points.size()));
}

CellWalk::CellWalk(const CellGrid& grid, std::size_t start) : grid_(grid) {
  if (start >= grid.cells()) return;
  for (std::size_t row = 0; row < 9; ++row) {
    const std::uint64_t middle = row_key(grid.key[start], row);
    const auto at = std::lower_bound(grid.key.begin(), grid.key.end(), middle - 1) - grid.key.begin();
    low_[row] = high_[row] = static_cast<std::size_t>(at);
  }
}

const std::array<CellRun, 9>& CellWalk::at(std::size_t cell) {
  for (std::size_t row = 0; row < 9; ++row) {
    const std::uint64_t middle = row_key(grid_.key[cell], row);
    while (low_[row] < grid_.cells() && grid_.key[low_[row]] < middle - 1) ++low_[row];
    while (high_[row] < grid_.cells() && grid_.key[high_[row]] <= middle + 1) ++high_[row];
    runs_[row] = {grid_.first[low_[row]], grid_.first[high_[row]]};
  }
  return runs_;
}

} // namespace pliant
