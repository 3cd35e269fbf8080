// Bonds between the points of one reference configuration, in rows.
#include "engine/core/error.h"
#include "engine/model/cells.h"
#include "engine/model/model.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace pliant {

namespace {

/// Cells handled by one thread at a time: long enough that starting a CellWalk does not matter.
constexpr std::size_t cells_at_once = 512;

/// Calls visit(particle, j) for every j closer to the particle than the horizon, and done(particle) after the
/// last.
template <class Visit, class Done>
void for_neighbours(const CellGrid& grid, double horizon, const Visit& visit, const Done& done) {
  const double reach = horizon * horizon;
  const std::size_t chunks = (grid.cells() + cells_at_once - 1) / cells_at_once;
#pragma omp parallel for schedule(dynamic)
  for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
    const std::size_t start = chunk * cells_at_once, end = std::min(start + cells_at_once, grid.cells());
    CellWalk walk(grid, start);
    for (std::size_t cell = start; cell < end; ++cell) {
      const auto& runs = walk.at(cell);
      for (std::uint32_t s = grid.first[cell]; s < grid.first[cell + 1]; ++s) {
        const Eigen::Vector3d here = grid.point[s];
        for (const CellRun& run : runs)
          for (std::uint32_t t = run.first; t < run.last; ++t) {
            const double x = grid.point[t].x() - here.x(), y = grid.point[t].y() - here.y(),
                         z = grid.point[t].z() - here.z();
            if (x * x + y * y + z * z < reach && t != s) visit(grid.order[s], grid.order[t]);
          }
        done(grid.order[s]);
      }
    }
  }
}

} // namespace

Bonds find_bonds(const std::vector<Vector3>& points, double horizon) {
  if (!(horizon > 0) || !std::isfinite(horizon))
    throw Error(ExitCode::usage, fmt::format("the horizon must be a positive length, not {} m", horizon));
  const CellGrid grid(points, horizon);
  std::vector<std::uint32_t> degree(points.size(), 0);
  for_neighbours(
      grid, horizon, [&](std::uint32_t i, std::uint32_t) { ++degree[i]; }, [](std::uint32_t) {});
  Bonds bonds;
  bonds.begin.resize(points.size() + 1);
  std::size_t total = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    bonds.begin[i] = static_cast<std::uint32_t>(total);
    total += degree[i];
    if (total > UINT32_MAX)
      throw Error(
          ExitCode::too_large,
          fmt::format("the first {} of {} particles have more bonds than 32 bits can count; use a larger "
                      "spacing or a smaller horizon",
                      i + 1, points.size()));
  }
  bonds.begin.back() = static_cast<std::uint32_t>(total);
  bonds.neighbour.resize(total);
  bonds.reverse.resize(total);
  std::fill(degree.begin(), degree.end(), 0);
  for_neighbours(
      grid, horizon,
      [&](std::uint32_t i, std::uint32_t j) { bonds.neighbour[bonds.begin[i] + degree[i]++] = j; },
      [&](std::uint32_t i) {
        std::sort(bonds.neighbour.begin() + bonds.begin[i], bonds.neighbour.begin() + bonds.begin[i + 1]);
      });
#pragma omp parallel for schedule(static)
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::uint32_t b = bonds.begin[i]; b < bonds.begin[i + 1]; ++b) {
      const std::uint32_t j = bonds.neighbour[b];
      const auto row = bonds.neighbour.begin();
      bonds.reverse[b] = static_cast<std::uint32_t>(
          std::lower_bound(row + bonds.begin[j], row + bonds.begin[j + 1], static_cast<std::uint32_t>(i)) -
          row);
    }
  return bonds;
}

} // namespace pliant
