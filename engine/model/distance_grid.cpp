// Samples signed distances on a grid: every fourth node exactly, the rest exactly only near the surface.
#include "engine/model/distance_grid.h"

#include "engine/core/error.h"

#include <algorithm>
#include <cmath>

namespace pliant {

namespace {

constexpr std::uint32_t stride = 4;

std::size_t index(const DistanceGrid& grid, std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  return (std::size_t{z} * grid.nodes[1] + y) * grid.nodes[0] + x;
}

} // namespace

double DistanceGrid::at(const Vector3& point, Vector3* gradient) const {
  std::array<std::uint32_t, 3> n{};
  std::array<double, 3> part{};
  for (int a = 0; a < 3; ++a) {
    const double s = std::clamp((point[a] - low[a]) / cell, 0.0, double(nodes[a] - 1));
    n[a] = std::min(static_cast<std::uint32_t>(s), nodes[a] - 2);
    part[a] = s - n[a];
  }
  double value = 0;
  Vector3 slope = Vector3::Zero();
  for (std::uint32_t c = 0; c < 8; ++c) {
    std::array<double, 3> w{}, dw{};
    for (std::uint32_t a = 0; a < 3; ++a) {
      const bool up = (c >> a) & 1;
      w[a] = up ? part[a] : 1 - part[a];
      dw[a] = up ? 1 : -1;
    }
    const double v = distance[index(*this, n[0] + (c & 1), n[1] + ((c >> 1) & 1), n[2] + (c >> 2))];
    value += w[0] * w[1] * w[2] * v;
    slope += v * Vector3(dw[0] * w[1] * w[2], w[0] * dw[1] * w[2], w[0] * w[1] * dw[2]);
  }
  if (gradient) *gradient = slope / cell;
  return value;
}

DistanceGrid grid_around(const ShapeQuery& shape, double cell, unsigned margin) {
  const std::vector<Vector3>& corners = shape.surface().vertices;
  if (corners.empty())
    throw Error(ExitCode::usage, "an obstacle without a surface cannot have a distance grid");
  Vector3 low = corners.front(), high = low;
  for (const Vector3& corner : corners) {
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
  }
  DistanceGrid grid;
  grid.cell = cell;
  grid.low = low - Vector3::Constant(margin * cell);
  double count = 1;
  for (int a = 0; a < 3; ++a) {
    // Whole blocks of `stride` cells, so that every node lies between coarse ones.
    const double cells = std::ceil((high[a] - low[a]) / cell) + 2 * margin;
    const double whole = stride * std::ceil(cells / stride);
    count *= whole + 1;
    if (!(count <= double(1 << 28)))
      throw Error(ExitCode::too_large,
                  "the distance grid of an obstacle would have more than 268 million nodes; "
                  "use a larger spacing or a smaller obstacle");
    grid.nodes[a] = static_cast<std::uint32_t>(whole) + 1;
  }
  return grid;
}

DistanceGrid make_distance_grid(const ShapeQuery& shape, double cell, unsigned margin) {
  DistanceGrid grid = grid_around(shape, cell, margin);
  grid.distance.assign(grid.count(), 0);
  const auto nodes = grid.nodes;
  const std::int64_t rows = std::int64_t{nodes[1]} * nodes[2];
#pragma omp parallel for schedule(dynamic, 4)
  for (std::int64_t row = 0; row < rows; ++row) {
    const auto y = static_cast<std::uint32_t>(row % nodes[1]), z = static_cast<std::uint32_t>(row / nodes[1]);
    if (y % stride || z % stride) continue;
    for (std::uint32_t x = 0; x < nodes[0]; x += stride)
      grid.distance[index(grid, x, y, z)] = shape.signed_distance(grid.node(x, y, z));
  }
  // A block all of whose corners are further from the surface than its diagonal and the margin holds no
  // surface.
  const double clear = (stride * std::sqrt(3.0) + margin) * cell;
  std::array<std::int64_t, 3> blocks{};
  for (int a = 0; a < 3; ++a) blocks[a] = (nodes[a] - 1) / stride;
    // Each block fills its own nodes and, at the far ends, those of the last face; coarse nodes stay.
#pragma omp parallel for schedule(dynamic, 4)
  for (std::int64_t block = 0; block < blocks[0] * blocks[1] * blocks[2]; ++block) {
    const std::array<std::uint32_t, 3> b{static_cast<std::uint32_t>(block % blocks[0]),
                                         static_cast<std::uint32_t>(block / blocks[0] % blocks[1]),
                                         static_cast<std::uint32_t>(block / (blocks[0] * blocks[1]))};
    std::array<double, 8> v{};
    double least = 1e300;
    for (std::uint32_t c = 0; c < 8; ++c) {
      v[c] = grid.distance[index(grid, stride * (b[0] + (c & 1)), stride * (b[1] + ((c >> 1) & 1)),
                                 stride * (b[2] + (c >> 2)))];
      least = std::min(least, std::abs(v[c]));
    }
    std::array<std::uint32_t, 3> end{};
    for (int a = 0; a < 3; ++a) end[a] = b[a] + 1 == blocks[a] ? stride : stride - 1;
    for (std::uint32_t z = 0; z <= end[2]; ++z)
      for (std::uint32_t y = 0; y <= end[1]; ++y)
        for (std::uint32_t x = 0; x <= end[0]; ++x) {
          if (x % stride == 0 && y % stride == 0 && z % stride == 0) continue;
          const std::uint32_t nx = stride * b[0] + x, ny = stride * b[1] + y, nz = stride * b[2] + z;
          double& out = grid.distance[index(grid, nx, ny, nz)];
          if (least <= clear) {
            out = shape.signed_distance(grid.node(nx, ny, nz));
            continue;
          }
          const double px = double(x) / stride, py = double(y) / stride, pz = double(z) / stride;
          out = 0;
          for (std::uint32_t c = 0; c < 8; ++c)
            out += (c & 1 ? px : 1 - px) * (c & 2 ? py : 1 - py) * (c & 4 ? pz : 1 - pz) * v[c];
        }
  }
  return grid;
}

} // namespace pliant
