// Particles from shapes: the points of a cell-centred lattice that lie inside.
#include "engine/scene/sample.h"

#include "engine/core/error.h"
#include "engine/core/memory.h"
#include "engine/scene/shape.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace pliant {
namespace {

constexpr double whole = 1e-6;       // cells; a side this near to a whole number of spacings is one
constexpr double bytes_a_point = 48; // in Sampling: two vectors
constexpr double most_cells = 4e9;   // of the lattice over the shape's box, one byte each

/// Lattice over the box of a shape: point (i + shift) * spacing along each axis, i from `first`, `count` of
/// them. Where a side holds an even number of cells no point lies at its middle, hence the shift by half a
/// cell.
struct Lattice {
  double spacing;
  std::array<double, 3> shift{};
  std::array<long long, 3> first{}, count{};

  Lattice(const Vector3& half, double cell) : spacing(cell) {
    for (std::size_t k = 0; k < 3; ++k) {
      const double reach = half[static_cast<Eigen::Index>(k)] / cell;
      if (!(reach < most_cells)) {
        count.fill(static_cast<long long>(most_cells));
        return;
      }
      shift[k] = std::llround(2 * reach) % 2 == 0 ? 0.5 : 0;
      first[k] = static_cast<long long>(std::ceil(-reach - shift[k] - whole));
      count[k] = std::max(0ll, static_cast<long long>(std::floor(reach - shift[k] + whole)) - first[k] + 1);
    }
  }
  double size() const { return double(count[0]) * double(count[1]) * double(count[2]); }
  Vector3 at(long long i, long long j, long long k) const {
    return spacing * Vector3(double(first[0] + i) + shift[0], double(first[1] + j) + shift[1],
                             double(first[2] + k) + shift[2]);
  }
  std::size_t index(long long i, long long j, long long k) const {
    return static_cast<std::size_t>((k * count[1] + j) * count[0] + i);
  }
};

/// Marks each lattice point in whose way from its neighbour at smaller x a triangle may lie: only there can a
/// closed mesh's winding number change, so that whole runs of points share one evaluation.
std::vector<std::uint8_t> mark_changes(const Mesh& mesh, const Lattice& lattice) {
  std::vector<std::uint8_t> change(static_cast<std::size_t>(lattice.size()), 0);
  for (const auto& t : mesh.triangles) {
    std::array<long long, 3> low{}, high{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto axis = static_cast<Eigen::Index>(k);
      const double a = mesh.vertices[t[0]][axis], b = mesh.vertices[t[1]][axis],
                   c = mesh.vertices[t[2]][axis];
      const double origin = double(lattice.first[k]) + lattice.shift[k];
      const double from = std::min({a, b, c}) / lattice.spacing - origin - whole;
      const double to = std::max({a, b, c}) / lattice.spacing - origin + whole;
      low[k] = std::max(0ll, static_cast<long long>(std::ceil(from)));
      high[k] =
          std::min(lattice.count[k] - 1, static_cast<long long>(k == 0 ? std::ceil(to) : std::floor(to)));
    }
    for (long long k = low[2]; k <= high[2]; ++k)
      for (long long j = low[1]; j <= high[1]; ++j)
        for (long long i = low[0]; i <= high[0]; ++i) change[lattice.index(i, j, k)] = 1;
  }
  return change;
}

/// One byte a lattice point: whether it lies inside.
std::vector<std::uint8_t> fill(const PlacedShape& placed, const MeshQuery* query, const Lattice& lattice) {
  std::vector<std::uint8_t> inside =
      query ? mark_changes(placed.mesh, lattice)
            : std::vector<std::uint8_t>(static_cast<std::size_t>(lattice.size()));
  const double slack = whole * lattice.spacing;
#pragma omp parallel for collapse(2) schedule(dynamic, 8)
  for (long long k = 0; k < lattice.count[2]; ++k)
    for (long long j = 0; j < lattice.count[1]; ++j) {
      std::uint8_t latest = 0;
      for (long long i = 0; i < lattice.count[0]; ++i) {
        std::uint8_t& mine = inside[lattice.index(i, j, k)];
        if (!query)
          latest = analytic_distance(placed.shape, lattice.at(i, j, k)) <= slack;
        else if (i == 0 || mine)
          latest = query->winding_number(lattice.at(i, j, k), sign_beta) > 0.5;
        mine = latest;
      }
    }
  return inside;
}

/// What keeps a mesh from being filled; a warning for what does not.
void check_closed(const PlacedShape& placed, std::vector<std::string>& warnings) {
  const MeshReport report = examine(placed.mesh);
  const std::string name = fmt::format("{} ({})", name_of(placed.shape), placed.file.string());
  if (report.open_edges + report.odd_edges > 0)
    throw Error(
        ExitCode::usage,
        fmt::format(
            "{} is open: {} of its edges belong to one triangle only, {} to more than two or to two that "
            "face opposite ways. A body needs a closed surface: fill the holes and make the normals "
            "consistent in a mesh editor, or give the body a thickness to make a sheet of it",
            name, report.open_edges, report.odd_edges));
  if (!(report.volume > 0))
    throw Error(ExitCode::usage,
                fmt::format("{} encloses no volume; a body needs a surface around a solid", name));
  if (placed.turned)
    warnings.push_back(fmt::format("{}: its triangles face inwards; they were turned around", name));
  if (report.crossing_pairs > 0)
    warnings.push_back(
        fmt::format("{}: {} pairs of its triangles cross; inside is where the winding number says so", name,
                    report.crossing_pairs));
}

/// A spacing at which the shape holds a particle, rounded down to two digits; 0 where none was found.
double spacing_that_would_do(const PlacedShape& placed, const MeshQuery* query, double spacing) {
  for (double tried = std::min(spacing, 2 * placed.half.minCoeff()); tried > 0; tried *= 0.7) {
    const double unit = std::pow(10, std::floor(std::log10(tried)) - 1),
                 rounded = std::floor(tried / unit) * unit;
    const Lattice lattice(placed.half, rounded);
    if (lattice.size() > 1e7) return 0;
    const std::vector<std::uint8_t> inside = fill(placed, query, lattice);
    if (std::find(inside.begin(), inside.end(), 1) != inside.end()) return rounded;
  }
  return 0;
}

} // namespace

Sampling sample(const Shape& shape, double spacing, const std::filesystem::path& scene_directory) {
  if (!(spacing > 0) || !std::isfinite(spacing))
    throw Error(ExitCode::usage, fmt::format("a spacing of {} m: it must be positive and finite", spacing));
  if (shape.kind == Shape::Kind::plane)
    throw Error(ExitCode::usage, "a plane has no inside to fill with particles; use a flat box");
  if (shape.kind == Shape::Kind::sheet)
    throw Error(ExitCode::usage, "a sheet has no inside to fill with particles; give the body a thickness");
  const PlacedShape placed = place(shape, scene_directory);
  Sampling sampling;
  std::optional<MeshQuery> query;
  if (shape.kind == Shape::Kind::mesh) {
    check_closed(placed, sampling.warnings);
    query.emplace(placed.mesh);
  }
  sampling.volume = volume_of(placed);
  const Lattice lattice(placed.half, spacing);
  if (lattice.size() > most_cells)
    throw Error(
        ExitCode::too_large,
        fmt::format(
            "{}: about {:.2g} particles at a spacing of {} m; their numbers have 32 bits. Raise the spacing",
            name_of(shape), sampling.volume / spacing / spacing / spacing, spacing));
  const double estimate = sampling.volume / spacing / spacing / spacing;
  require_memory(fmt::format("{}: about {:.2g} particles need at least", name_of(shape), estimate),
                 lattice.size() + bytes_a_point * estimate, available_memory(), spacing);
  const std::vector<std::uint8_t> inside = fill(placed, query ? &*query : nullptr, lattice);

  sampling.axes = placed.axes;
  sampling.origin = placed.to_world(spacing * Vector3(lattice.shift[0], lattice.shift[1], lattice.shift[2]));
  for (long long k = 0; k < lattice.count[2]; ++k)
    for (long long j = 0; j < lattice.count[1]; ++j)
      for (long long i = 0; i < lattice.count[0]; ++i) {
        if (!inside[lattice.index(i, j, k)]) continue;
        sampling.reference.push_back(spacing * Vector3(double(lattice.first[0] + i),
                                                       double(lattice.first[1] + j),
                                                       double(lattice.first[2] + k)));
        sampling.points.push_back(sampling.origin + sampling.axes * sampling.reference.back());
      }
  if (sampling.points.empty()) {
    const double good = spacing_that_would_do(placed, query ? &*query : nullptr, spacing);
    throw Error(
        ExitCode::usage,
        fmt::format("{}: too small to hold a particle at a spacing of {} m; {}", name_of(shape), spacing,
                    good > 0 ? fmt::format("a spacing of {:.2g} m would do", good)
                             : fmt::format("its smallest side is {:.2g} m", 2 * placed.half.minCoeff())));
  }
  sampling.surface = surface_of(placed, spacing);
  return sampling;
}

} // namespace pliant
