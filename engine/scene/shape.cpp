// Shapes in their place, and exact distances to the analytic ones.
#include "engine/scene/shape.h"

#include "engine/core/error.h"
#include "engine/scene/sample.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>

namespace pliant {
namespace {

void require_positive(const Shape& shape, const char* what, double value) {
  if (!(value > 0) || !std::isfinite(value))
    throw Error(ExitCode::usage, fmt::format("{}: its {} is {} m; it must be positive and finite",
                                             name_of(shape), what, value));
}

double signed_volume(const Mesh& mesh) {
  double six = 0;
  for (const auto& t : mesh.triangles)
    six += mesh.vertices[t[0]].dot(mesh.vertices[t[1]].cross(mesh.vertices[t[2]]));
  return six / 6;
}

void place_mesh(PlacedShape& placed, const std::filesystem::path& scene_directory) {
  const Shape& shape = placed.shape;
  placed.file = find_mesh(shape.mesh, scene_directory);
  placed.mesh = read_mesh(placed.file);
  Mesh& mesh = placed.mesh;
  // Vertices that no triangle uses do not count.
  Vector3 low = mesh.vertices[mesh.triangles[0][0]], high = low;
  for (const auto& t : mesh.triangles)
    for (const std::uint32_t v : t) {
      low = low.cwiseMin(mesh.vertices[v]);
      high = high.cwiseMax(mesh.vertices[v]);
    }
  const double longest = (high - low).maxCoeff();
  if (!(longest > 0) || !std::isfinite(longest))
    throw Error(ExitCode::usage,
                fmt::format("{} ({}): the longest side of its box is {}; there is nothing to fill",
                            name_of(shape), placed.file.string(), longest));
  if (shape.fit) require_positive(shape, "fit", *shape.fit);
  const double scale = shape.fit ? *shape.fit / longest : 1;
  const Vector3 middle = (low + high) / 2;
  for (Vector3& v : mesh.vertices) v = scale * (v - middle);
  placed.half = scale * (high - low) / 2;
  placed.centre = shape.place.value_or(middle);
  placed.turned = signed_volume(mesh) < 0;
  if (placed.turned)
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
}

double distance_to_box(const Vector3& half, const Vector3& p) {
  const Vector3 beyond = p.cwiseAbs() - half;
  return beyond.cwiseMax(0.0).norm() + std::min(beyond.maxCoeff(), 0.0);
}

} // namespace

std::string name_of(const Shape& shape) {
  switch (shape.kind) {
  case Shape::Kind::box:
    return "box";
  case Shape::Kind::sphere:
    return "sphere";
  case Shape::Kind::cylinder:
    return "cylinder";
  case Shape::Kind::torus:
    return "torus";
  case Shape::Kind::mesh:
    return fmt::format("mesh '{}'", shape.mesh);
  case Shape::Kind::sheet:
    return "sheet";
  case Shape::Kind::plane:
    break;
  }
  return "plane";
}

PlacedShape place(const Shape& shape, const std::filesystem::path& scene_directory) {
  PlacedShape placed;
  placed.shape = shape;
  placed.centre = shape.at;
  const double r = shape.radius, t = shape.tube;
  switch (shape.kind) {
  case Shape::Kind::box:
    require_positive(shape, "smallest edge", shape.size.minCoeff());
    require_positive(shape, "largest edge", shape.size.maxCoeff());
    placed.half = shape.size / 2;
    break;
  case Shape::Kind::sphere:
    require_positive(shape, "radius", r);
    placed.half.setConstant(r);
    break;
  case Shape::Kind::cylinder:
    require_positive(shape, "radius", r);
    require_positive(shape, "height", shape.height);
    placed.half = {r, shape.height / 2, r};
    break;
  case Shape::Kind::torus:
    require_positive(shape, "radius", r);
    require_positive(shape, "tube", t);
    if (t >= r)
      throw Error(ExitCode::usage,
                  fmt::format("torus: its tube of radius {} m must be thinner than its ring of {} m", t, r));
    placed.half = {r + t, t, r + t};
    break;
  case Shape::Kind::mesh:
    place_mesh(placed, scene_directory);
    break;
  case Shape::Kind::sheet: {
    const auto [width, height] = shape.sheet.value_or(std::array<double, 2>{0, 0});
    require_positive(shape, "width", width);
    require_positive(shape, "height", height);
    placed.half = {width / 2, height / 2, 0};
    break;
  }
  case Shape::Kind::plane:
    return placed;
  }
  if (shape.rotate_degrees != 0) {
    require_positive(shape, "axis of rotation", shape.rotate_axis.norm());
    placed.axes =
        Eigen::AngleAxisd(shape.rotate_degrees * std::numbers::pi / 180, shape.rotate_axis.normalized());
  }
  return placed;
}

double volume_of(const PlacedShape& placed) {
  const Shape& s = placed.shape;
  constexpr double pi = std::numbers::pi;
  switch (s.kind) {
  case Shape::Kind::box:
    return s.size.prod();
  case Shape::Kind::sphere:
    return 4 * pi / 3 * s.radius * s.radius * s.radius;
  case Shape::Kind::cylinder:
    return pi * s.radius * s.radius * s.height;
  case Shape::Kind::torus:
    return 2 * pi * pi * s.radius * s.tube * s.tube;
  case Shape::Kind::mesh:
    return signed_volume(placed.mesh);
  case Shape::Kind::plane:
  case Shape::Kind::sheet: // one layer encloses nothing
    break;
  }
  return 0;
}

double analytic_distance(const Shape& shape, const Vector3& own) {
  const double from_axis = std::hypot(own[0], own[2]);
  switch (shape.kind) {
  case Shape::Kind::box:
    return distance_to_box(shape.size / 2, own);
  case Shape::Kind::sphere:
    return own.norm() - shape.radius;
  case Shape::Kind::cylinder: // a box in the half-plane through its axis
    return distance_to_box({shape.radius, shape.height / 2, 1e300}, {from_axis, own[1], 0});
  case Shape::Kind::torus:
    return std::hypot(from_axis - shape.radius, own[1]) - shape.tube;
  case Shape::Kind::mesh:
  case Shape::Kind::plane:
  case Shape::Kind::sheet:
    break;
  }
  throw Error(ExitCode::internal, fmt::format("{}: it has no distance in closed form", name_of(shape)));
}

struct ShapeQuery::Impl {
  PlacedShape placed;
  std::optional<MeshQuery> mesh;
  Mesh surface;
};

ShapeQuery::ShapeQuery(const Shape& shape, const std::filesystem::path& scene_directory)
    : impl_(new Impl{place(shape, scene_directory), {}, {}}) {
  if (shape.kind == Shape::Kind::mesh) impl_->mesh.emplace(impl_->placed.mesh);
  impl_->surface = surface_of(impl_->placed, impl_->placed.half.maxCoeff() / 12);
}

ShapeQuery::~ShapeQuery() = default;
ShapeQuery::ShapeQuery(ShapeQuery&&) noexcept = default;

bool ShapeQuery::contains(const Vector3& point) const {
  if (impl_->mesh) return impl_->mesh->winding_number(impl_->placed.to_own(point), sign_beta) > 0.5;
  return signed_distance(point) <= 0;
}

double ShapeQuery::signed_distance(const Vector3& point) const {
  const Shape& shape = impl_->placed.shape;
  if (shape.kind == Shape::Kind::plane) return shape.normal.dot(point) - shape.offset;
  const Vector3 own = impl_->placed.to_own(point);
  if (!impl_->mesh) return analytic_distance(shape, own);
  const double distance = impl_->mesh->distance(own);
  return impl_->mesh->winding_number(own, sign_beta) > 0.5 ? -distance : distance;
}

const Mesh& ShapeQuery::surface() const {
  return impl_->surface;
}

} // namespace pliant
