// Particles of single layers: a square lattice over what is flat, points spread evenly over what is curved.
//
// Curved surfaces: many points, uniform by area, stand for the surface; from them a maximal set at least
// 0.834 spacings apart (random sequential addition jams at 0.547 of the area under its discs: one particle to
// a square of the spacing), which Lloyd's (1982) iteration evens out: each particle moves to the middle of
// the points nearest to it, and back onto the surface.
#include "engine/core/error.h"
#include "engine/core/memory.h"
#include "engine/scene/mesh_cross.h"
#include "engine/scene/sample.h"
#include "engine/scene/shape.h"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <unordered_map>

namespace pliant {
namespace {

constexpr double whole = 1e-6;         // cells; a side this near to a whole number of spacings is one
constexpr double flat_enough = 1e-6;   // of a mesh's size, from its plane
constexpr double points_a_square = 48; // of the spacing, that stand for a curved surface
constexpr double closest = 0.834;      // spacings, in the first set
constexpr int rounds = 24;             // of Lloyd's iteration; later ones move particles by less than 1 %
constexpr double most_particles = 4e9; // their numbers have 32 bits
constexpr double bytes_a_point = 160;  // while a surface is sampled

/// Cell-centred square lattice over [low, high] of a plane, centred on it; see Lattice of sample.cpp.
struct SquareLattice {
  double spacing;
  std::array<double, 2> start{}; ///< of the first point
  std::array<long long, 2> count{}, first{};
  std::array<double, 2> middle{};

  SquareLattice(const std::array<double, 2>& low, const std::array<double, 2>& high, double cell)
      : spacing(cell) {
    for (std::size_t k = 0; k < 2; ++k) {
      const double reach = (high[k] - low[k]) / 2 / cell;
      if (!(reach < std::sqrt(most_particles))) throw_too_many(4 * reach * reach, cell);
      const double shift = std::llround(2 * reach) % 2 == 0 ? 0.5 : 0;
      first[k] = static_cast<long long>(std::ceil(-reach - shift - whole));
      count[k] = std::max(0ll, static_cast<long long>(std::floor(reach - shift + whole)) - first[k] + 1);
      middle[k] = (low[k] + high[k]) / 2 + shift * cell;
    }
  }
  [[noreturn]] static void throw_too_many(double particles, double cell) {
    throw Error(
        ExitCode::too_large,
        fmt::format(
            "about {:.2g} particles at a spacing of {} m; their numbers have 32 bits. Raise the spacing",
            particles, cell));
  }
  /// Relative to `middle`, which is a point of the lattice.
  Vector3 at(long long i, long long j) const {
    return spacing * Vector3(double(first[0] + i), double(first[1] + j), 0);
  }
};

void check(double thickness, double spacing) {
  if (!(spacing > 0) || !std::isfinite(spacing))
    throw Error(ExitCode::usage, fmt::format("a spacing of {} m: it must be positive and finite", spacing));
  if (!(thickness > 0) || !std::isfinite(thickness))
    throw Error(ExitCode::usage,
                fmt::format("a thickness of {} m: it must be positive and finite", thickness));
}

void check_memory(const std::string& name, double area, double spacing, double bytes) {
  const double estimate = area / (spacing * spacing);
  if (!(estimate < most_particles)) SquareLattice::throw_too_many(estimate, spacing);
  require_memory(fmt::format("{}: about {:.2g} particles need at least", name, estimate), bytes * estimate,
                 available_memory(), spacing);
}

/// Fills `sampling` with the points of the lattice that `inside` takes; own = basis * (x, y, 0) + offset.
template <class Inside>
void fill(Sampling& sampling, const PlacedShape& placed, const SquareLattice& lattice, const Matrix3& basis,
          const Vector3& offset, const Inside& inside) {
  sampling.axes = placed.axes * basis;
  sampling.origin = placed.to_world(basis * Vector3(lattice.middle[0], lattice.middle[1], 0) + offset);
  for (long long j = 0; j < lattice.count[1]; ++j)
    for (long long i = 0; i < lattice.count[0]; ++i) {
      const Vector3 at = lattice.at(i, j);
      if (!inside(at + Vector3(lattice.middle[0], lattice.middle[1], 0), i, j)) continue;
      sampling.reference.push_back(at);
      sampling.points.push_back(sampling.origin + sampling.axes * at);
    }
  if (sampling.points.empty())
    throw Error(
        ExitCode::usage,
        fmt::format("{}: too small to hold a particle at a spacing of {} m; its smallest side is {:.2g} m",
                    name_of(placed.shape), lattice.spacing, 2 * std::min(placed.half.x(), placed.half.y())));
}

double triangle_area(const Mesh& mesh, const std::array<std::uint32_t, 3>& t) {
  return (mesh.vertices[t[1]] - mesh.vertices[t[0]]).cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]).norm() /
         2;
}

/// A number in [0, 1) for each index: SplitMix64 (Steele, Lea, Flood 2014).
double uniform(std::uint64_t index) {
  std::uint64_t z = 20180801 + (index + 1) * 0x9E3779B97F4A7C15u;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

/// Points in cells of a given size, to find those near a place.
class Near {
public:
  explicit Near(double cell) : cell_(cell) {}
  void clear() { cells_.clear(); }
  void add(const Vector3& x, std::uint32_t index) { cells_[key(place(x))].push_back(index); }
  /// Calls visit(index) for all within one cell's size, and some more.
  template <class Visit> void around(const Vector3& x, const Visit& visit) const {
    const Eigen::Vector3i middle = place(x);
    for (int dz = -1; dz <= 1; ++dz)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
          if (const auto found = cells_.find(key(middle + Eigen::Vector3i(dx, dy, dz)));
              found != cells_.end())
            for (const std::uint32_t index : found->second) visit(index);
  }

private:
  Eigen::Vector3i place(const Vector3& x) const { return (x / cell_).array().floor().cast<int>(); }
  static std::uint64_t key(const Eigen::Vector3i& c) {
    const auto part = [](int v) { return static_cast<std::uint64_t>(v + (1 << 20)) & 0x1fffff; };
    return part(c.x()) | part(c.y()) << 21 | part(c.z()) << 42;
  }
  double cell_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;
};

/// `count` points of the surface, the same number to each area: one at random in each of as many equal shares
/// of it.
std::vector<Vector3> cover(const Mesh& mesh, double area, std::size_t count) {
  std::vector<Vector3> points;
  points.reserve(count);
  double before = 0;
  for (const auto& t : mesh.triangles) {
    const double own = triangle_area(mesh, t), share = area / static_cast<double>(count);
    const Vector3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    while (points.size() < count && (static_cast<double>(points.size()) + 0.5) * share < before + own) {
      const std::uint64_t index = 2 * points.size();
      const double root = std::sqrt(uniform(index)), across = uniform(index + 1);
      points.push_back((1 - root) * a + root * ((1 - across) * b + across * c));
    }
    before += own;
  }
  return points;
}

/// One particle to a square of the spacing, spread evenly over a curved surface.
std::vector<Vector3> spread(const Mesh& mesh, double area, double spacing) {
  const auto wanted =
      static_cast<std::size_t>(std::max(64.0, std::ceil(points_a_square * area / (spacing * spacing))));
  const std::vector<Vector3> cloud = cover(mesh, area, wanted);
  std::vector<std::uint32_t> order(cloud.size());
  std::iota(order.begin(), order.end(), 0u);
  std::vector<double> lot(cloud.size());
  for (std::size_t p = 0; p < cloud.size(); ++p) lot[p] = uniform(p + (1ull << 40));
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return lot[a] < lot[b]; });
  std::vector<Vector3> chosen;
  Near near(1.5 * spacing); // wide enough to hold the nearest of any point's particles
  const double least = closest * spacing;
  for (const std::uint32_t p : order) {
    bool room = true;
    near.around(cloud[p], [&](std::uint32_t i) { room = room && (chosen[i] - cloud[p]).norm() >= least; });
    if (!room) continue;
    near.add(cloud[p], static_cast<std::uint32_t>(chosen.size()));
    chosen.push_back(cloud[p]);
  }
  const MeshQuery surface(mesh);
  std::vector<std::uint32_t> owner(cloud.size());
  for (int round = 0; round < rounds; ++round) {
#pragma omp parallel for schedule(static)
    for (std::size_t p = 0; p < cloud.size(); ++p) {
      double best = 1e300;
      near.around(cloud[p], [&](std::uint32_t i) {
        const double distance = (chosen[i] - cloud[p]).squaredNorm();
        if (distance < best || (distance == best && i < owner[p])) best = distance, owner[p] = i;
      });
    }
    std::vector<Vector3> sum(chosen.size(), Vector3::Zero());
    std::vector<double> members(chosen.size(), 0);
    for (std::size_t p = 0; p < cloud.size(); ++p) sum[owner[p]] += cloud[p], members[owner[p]] += 1;
#pragma omp parallel for schedule(static)
    for (std::size_t i = 0; i < chosen.size(); ++i)
      if (members[i] > 0) surface.distance(sum[i] / members[i], &chosen[i]);
    near.clear();
    for (std::uint32_t i = 0; i < chosen.size(); ++i) near.add(chosen[i], i);
  }
  return chosen;
}

/// The plane that all vertices lie in, as axes whose third is its normal; nothing where there is none.
std::optional<Matrix3> plane_of(const PlacedShape& placed) {
  Vector3 normal = Vector3::Zero();
  for (const auto& t : placed.mesh.triangles)
    normal += (placed.mesh.vertices[t[1]] - placed.mesh.vertices[t[0]])
                  .cross(placed.mesh.vertices[t[2]] - placed.mesh.vertices[t[0]]);
  if (!(normal.norm() > 0)) return std::nullopt;
  normal.normalize();
  const Vector3& origin = placed.mesh.vertices[placed.mesh.triangles[0][0]];
  for (const auto& t : placed.mesh.triangles)
    for (const std::uint32_t v : t)
      if (std::abs(normal.dot(placed.mesh.vertices[v] - origin)) > flat_enough * placed.half.maxCoeff())
        return std::nullopt;
  // Rows along the axis of the file that lies most nearly in the plane.
  Eigen::Index axis = 0;
  normal.cwiseAbs().minCoeff(&axis);
  Matrix3 basis;
  basis.col(2) = normal;
  basis.col(0) = (Vector3::Unit(axis) - normal[axis] * normal).normalized();
  basis.col(1) = normal.cross(basis.col(0));
  return basis;
}

void sample_flat_mesh(Sampling& sampling, const PlacedShape& placed, const Matrix3& basis, double spacing) {
  std::vector<Vector3> flat;
  for (const Vector3& v : placed.mesh.vertices) flat.push_back(basis.transpose() * v);
  std::array<double, 2> low{1e300, 1e300}, high{-1e300, -1e300};
  for (const auto& t : placed.mesh.triangles)
    for (const std::uint32_t v : t)
      for (std::size_t k = 0; k < 2; ++k) {
        low[k] = std::min(low[k], flat[v][static_cast<Eigen::Index>(k)]);
        high[k] = std::max(high[k], flat[v][static_cast<Eigen::Index>(k)]);
      }
  const SquareLattice lattice(low, high, spacing);
  const auto columns = static_cast<std::size_t>(lattice.count[0]);
  std::vector<std::uint8_t> inside(columns * static_cast<std::size_t>(lattice.count[1]), 0);
  for (const auto& t : placed.mesh.triangles) {
    const Vector3 a = flat[t[0]], b = flat[t[1]], c = flat[t[2]];
    const auto side = [](const Vector3& p, const Vector3& q, double x, double y) {
      return (q.x() - p.x()) * (y - p.y()) - (q.y() - p.y()) * (x - p.x());
    };
    const double turn = side(a, b, c.x(), c.y()) < 0 ? -1 : 1;
    const double slack = whole * spacing * (c - a).cwiseAbs().sum();
    const auto index = [&](double value, std::size_t k) {
      return (value - lattice.middle[k]) / spacing - static_cast<double>(lattice.first[k]);
    };
    const auto from = [&](std::size_t k) {
      const auto e = static_cast<Eigen::Index>(k);
      return std::max(0ll, static_cast<long long>(std::ceil(index(std::min({a[e], b[e], c[e]}), k) - whole)));
    };
    const auto to = [&](std::size_t k) {
      const auto e = static_cast<Eigen::Index>(k);
      return std::min(lattice.count[k] - 1,
                      static_cast<long long>(std::floor(index(std::max({a[e], b[e], c[e]}), k) + whole)));
    };
    for (long long j = from(1); j <= to(1); ++j)
      for (long long i = from(0); i <= to(0); ++i) {
        const Vector3 p = lattice.at(i, j) + Vector3(lattice.middle[0], lattice.middle[1], 0);
        if (turn * side(a, b, p.x(), p.y()) >= -slack && turn * side(b, c, p.x(), p.y()) >= -slack &&
            turn * side(c, a, p.x(), p.y()) >= -slack)
          inside[static_cast<std::size_t>(j) * columns + static_cast<std::size_t>(i)] = 1;
      }
  }
  const double height = flat[placed.mesh.triangles[0][0]].z();
  fill(sampling, placed, lattice, basis, height * basis.col(2),
       [&](const Vector3&, long long i, long long j) {
         return inside[static_cast<std::size_t>(j) * columns + static_cast<std::size_t>(i)] != 0;
       });
}

void sample_curved_mesh(Sampling& sampling, const PlacedShape& placed, double area, double spacing) {
  const std::vector<Vector3> points = spread(placed.mesh, area, spacing);
  sampling.axes = placed.axes;
  sampling.origin = placed.centre;
  for (const Vector3& p : points) {
    sampling.reference.push_back(p);
    sampling.points.push_back(placed.to_world(p));
  }
}

} // namespace

Sampling sample_sheet(const Shape& shape, double thickness, double spacing,
                      const std::filesystem::path& scene_directory) {
  check(thickness, spacing);
  const PlacedShape placed = place(shape, scene_directory);
  Sampling sampling;
  if (shape.kind == Shape::Kind::sheet) {
    const double x = placed.half.x(), y = placed.half.y();
    check_memory(name_of(shape), 4 * x * y, spacing, 48);
    const SquareLattice lattice({-x, -y}, {x, y}, spacing);
    fill(sampling, placed, lattice, Matrix3::Identity(), Vector3::Zero(),
         [](const Vector3&, long long, long long) { return true; });
    sampling.volume = 4 * x * y * thickness;
  } else if (shape.kind == Shape::Kind::mesh) {
    const MeshReport report = measure(placed.mesh);
    const std::string name = fmt::format("{} ({})", name_of(shape), placed.file.string());
    if (report.odd_edges > 0)
      throw Error(
          ExitCode::usage,
          fmt::format(
              "{}: {} of its edges belong to more than two triangles or to two that face opposite ways; "
              "a sheet has one triangle at an edge of its rim and two elsewhere",
              name, report.odd_edges));
    if (!(report.area > 0)) throw Error(ExitCode::usage, fmt::format("{}: its triangles have no area", name));
    check_memory(name, report.area, spacing, bytes_a_point * points_a_square);
    if (const std::optional<Matrix3> basis = plane_of(placed))
      sample_flat_mesh(sampling, placed, *basis, spacing);
    else
      sample_curved_mesh(sampling, placed, report.area, spacing);
    sampling.volume = report.area * thickness;
  } else {
    throw Error(ExitCode::usage, fmt::format("a {} is no sheet; give it no thickness", name_of(shape)));
  }
  sampling.surface = surface_of(placed, spacing);
  return sampling;
}

Sampling sample_section(const Shape& shape, double thickness, double spacing,
                        const std::filesystem::path& scene_directory) {
  check(thickness, spacing);
  const PlacedShape placed = place(shape, scene_directory);
  const double x = placed.half.x(), y = placed.half.y();
  const bool disc = shape.kind == Shape::Kind::sphere;
  const bool rectangle = shape.kind == Shape::Kind::box || shape.kind == Shape::Kind::cylinder ||
                         shape.kind == Shape::Kind::sheet;
  if (!disc && !rectangle)
    throw Error(ExitCode::usage,
                fmt::format("a {} has no section in a scene of dimension 2", name_of(shape)));
  Sampling sampling;
  const double area = disc ? std::numbers::pi * x * x : 4 * x * y;
  check_memory(name_of(shape), area, spacing, 48);
  const SquareLattice lattice({-x, -y}, {x, y}, spacing);
  const double reach = x + whole * spacing;
  fill(sampling, placed, lattice, Matrix3::Identity(), Vector3::Zero(),
       [&](const Vector3& at, long long, long long) { return !disc || at.norm() <= reach; });
  sampling.volume = area * thickness;
  Mesh surface = disc ? triangulate_disc(x, 64, 8)
                      : triangulate_rectangle(2 * x, 2 * y, std::max(spacing, std::sqrt(area / 5000)));
  for (Vector3& v : surface.vertices) v = placed.to_world(v);
  sampling.surface = std::move(surface);
  return sampling;
}

} // namespace pliant
