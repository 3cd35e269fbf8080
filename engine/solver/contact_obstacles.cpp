// Boundaries of the scene as rows of numbers.
#include "engine/solver/contact_obstacles.h"

#include "engine/core/error.h"
#include "shaders/common/contact.glsl"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pliant {

namespace {

constexpr double everywhere = 1e18; // m; its square is still a float

double bound_of(const Shape& shape) {
  switch (shape.kind) {
  case Shape::Kind::box:
    return shape.size.norm() / 2;
  case Shape::Kind::sphere:
    return shape.radius;
  case Shape::Kind::cylinder:
    return std::hypot(shape.radius, shape.height / 2);
  case Shape::Kind::torus:
    return shape.radius + shape.tube;
  default:
    return everywhere;
  }
}

DistanceGrid grid_of(const Scene& scene, const Boundary& boundary, double cell, bool measure_only) {
  try {
    const ShapeQuery query(boundary.shape, scene.file.parent_path());
    return measure_only ? grid_around(query, cell) : make_distance_grid(query, cell);
  } catch (const Error& error) {
    throw Error(error.code(), scene.file.string() + boundary.typed_at + ": boundary '" + boundary.name +
                                  "': " + error.what());
  }
}

} // namespace

Obstacles::Obstacles(const Scene& scene, double radius, double cell, bool measure_only) {
  if (scene.boundaries.size() > OBSTACLES)
    throw Error(ExitCode::usage, "the scene has " + std::to_string(scene.boundaries.size()) +
                                     " boundaries; at most " + std::to_string(OBSTACLES) +
                                     " are possible: join some into one mesh");
  for (const Boundary& boundary : scene.boundaries) {
    const Shape& shape = boundary.shape;
    Obstacle o;
    o.friction = boundary.slip ? boundary.friction : 0;
    o.no_slip = !boundary.slip;
    o.inside = boundary.inside;
    o.motion = boundary.motion;
    o.centre = shape.at;
    if (shape.rotate_degrees != 0)
      o.axes =
          Eigen::AngleAxisd(shape.rotate_degrees * std::numbers::pi / 180, shape.rotate_axis.normalized());
    switch (shape.kind) {
    case Shape::Kind::plane:
      o.kind = OBSTACLE_PLANE;
      o.centre = shape.offset * shape.normal;
      o.axes = Eigen::Quaterniond::FromTwoVectors(Vector3(0, 1, 0), shape.normal);
      break;
    case Shape::Kind::sphere:
      o.kind = OBSTACLE_SPHERE;
      o.size = {shape.radius, 0, 0};
      break;
    case Shape::Kind::box:
      o.kind = OBSTACLE_BOX;
      o.size = shape.size / 2;
      break;
    case Shape::Kind::cylinder:
      o.kind = OBSTACLE_CYLINDER;
      o.size = {shape.radius, shape.height / 2, 0};
      break;
    case Shape::Kind::torus:
      o.kind = OBSTACLE_TORUS;
      o.size = {shape.radius, shape.tube, 0};
      break;
    case Shape::Kind::sheet:
      throw Error(ExitCode::usage,
                  "boundary '" + boundary.name + "': a sheet keeps nothing out; use a thin box");
    case Shape::Kind::mesh: {
      o.kind = OBSTACLE_MESH;
      o.axes.setIdentity(); // the grid lies along the world's axes before any motion
      DistanceGrid grid = grid_of(scene, boundary, cell, measure_only);
      const Vector3 half = cell / 2 * Vector3(grid.nodes[0] - 1, grid.nodes[1] - 1, grid.nodes[2] - 1);
      o.centre = grid.low + half;
      o.low = -half;
      o.cell = cell;
      o.grid = {grid.nodes[0], grid.nodes[1], grid.nodes[2], static_cast<std::uint32_t>(grid_nodes_)};
      grid_nodes_ += grid.count();
      distances_.insert(distances_.end(), grid.distance.begin(), grid.distance.end());
      o.around = half.norm();
      break;
    }
    }
    if (shape.kind != Shape::Kind::mesh) o.around = bound_of(shape);
    o.around = o.inside ? everywhere : std::min(1.0001 * (o.around + radius), everywhere);
    obstacles_.push_back(o);
  }
  if (grid_nodes_ > UINT32_MAX)
    throw Error(ExitCode::too_large,
                "the distance grids of the boundaries need more nodes than 32 bits can number; "
                "use a larger spacing");
}

std::vector<Real4<double>> Obstacles::table(double begin, double end, const Vector3& origin) const {
  std::vector<Real4<double>> rows(std::size_t{OBSTACLES} * OBSTACLE_ROWS);
  Real4<double>* row = rows.data();
  for (const Obstacle& o : obstacles_) {
    if (released(o.motion, end)) { // a ball of no size where nothing is
      row[OBSTACLE_KIND] = {OBSTACLE_SPHERE, 0, 0, 0};
      row[OBSTACLE_CENTRE] = {everywhere, 0, 0, 0};
      row += OBSTACLE_ROWS;
      continue;
    }
    const RigidMap before = motion_at(o.motion, begin), after = motion_at(o.motion, end);
    const Vector3 centre = after(o.centre);
    const Matrix3 axes = after.rotation * o.axes;
    // A point of the obstacle at centre + r was at before(after^-1(.)): its displacement is W r + w.
    const Matrix3 back = before.rotation * after.rotation.transpose();
    const Matrix3 turned = Matrix3::Identity() - back;
    const Vector3 moved = centre - before(o.centre);
    row[OBSTACLE_KIND] = {o.kind, o.friction, o.no_slip ? 1.0 : 0.0, o.inside ? 1.0 : 0.0};
    const Vector3 place = centre - origin;
    row[OBSTACLE_CENTRE] = {place[0], place[1], place[2], o.around};
    row[OBSTACLE_SIZE] = {o.size[0], o.size[1], o.size[2], o.cell};
    for (int a = 0; a < 3; ++a) {
      row[OBSTACLE_AXES + a] = {axes(a, 0), axes(a, 1), axes(a, 2), o.low[a]};
      row[OBSTACLE_SHIFT + a] = {turned(a, 0), turned(a, 1), turned(a, 2), moved[a]};
    }
    row += OBSTACLE_ROWS;
  }
  return rows;
}

std::vector<std::uint32_t> Obstacles::grid_table() const {
  std::vector<std::uint32_t> rows(std::size_t{4} * OBSTACLES);
  for (std::size_t o = 0; o < obstacles_.size(); ++o)
    std::copy(obstacles_[o].grid.begin(), obstacles_[o].grid.end(),
              rows.begin() + static_cast<std::ptrdiff_t>(4 * o));
  return rows;
}

} // namespace pliant
