// The signed distance of a shape at the nodes of a regular grid, for obstacles without a closed form.
//
//   d is read between the nodes by trilinear interpolation, which is exact for flat pieces and rounds edges
//   within a cell. Nodes far from the surface are interpolated from every fourth: right in sign, a little off
//   in size.
#pragma once

#include "engine/scene/sample.h"

#include <array>
#include <cstdint>
#include <vector>

namespace pliant {

struct DistanceGrid {
  std::array<std::uint32_t, 3> nodes{}; ///< in x, y, z; at least 2
  Vector3 low = Vector3::Zero();        ///< m, world; the node of index 0, 0, 0
  double cell = 0;                      ///< m
  std::vector<double> distance;         ///< m, negative inside; x fastest

  std::size_t count() const { return std::size_t{nodes[0]} * nodes[1] * nodes[2]; }
  Vector3 node(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
    return low + cell * Vector3(x, y, z);
  }
  /// Trilinear; m. `gradient` may be null. Beyond the grid: that of the nearest point in it.
  double at(const Vector3& point, Vector3* gradient = nullptr) const;
};

/// Place and size of the grid of a shape's surface with `margin` cells to each side; no distances yet. Throws
/// Error(usage) where the shape has no surface (planes), Error(too_large) for more than 2^28 nodes.
DistanceGrid grid_around(const ShapeQuery& shape, double cell, unsigned margin = 3);

/// The same with its distances.
DistanceGrid make_distance_grid(const ShapeQuery& shape, double cell, unsigned margin = 3);

} // namespace pliant
