// Frames a scene.
#include "backends/gl/render/camera.h"

#include "backends/gl/render/legend.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace pliant::gl {

namespace {

constexpr double degree = 3.14159265358979323846 / 180;
// Share of the picture's width or height, whichever is filled first.
constexpr double filled = 0.70;

/// How far the points reach in the picture, in normalised device units.
struct Extent {
  double left = 1e300, right = -1e300, bottom = 1e300, top = -1e300;
};

Extent extent(const View& view, const std::vector<Vector3>& points) {
  Extent result;
  for (const Vector3& point : points) {
    const Vector3 d = point - view.eye;
    const double depth = std::max(d.dot(view.forward), 1e-9);
    const double x = d.dot(view.right) / (depth * view.tangent * view.aspect);
    const double y = d.dot(view.up) / (depth * view.tangent);
    result.left = std::min(result.left, x);
    result.right = std::max(result.right, x);
    result.bottom = std::min(result.bottom, y);
    result.top = std::max(result.top, y);
  }
  return result;
}

void look(View& view, const Vector3& forward, const Vector3& up) {
  view.forward = forward.normalized();
  Vector3 right = view.forward.cross(up);
  if (right.norm() < 1e-6) right = view.forward.cross(Vector3(0.3, 0.5, -0.8)); // straight up or down
  view.right = right.normalized();
  view.up = view.right.cross(view.forward);
}

/// Unit vectors in the horizontal plane: to the right of someone who looks against `front`.
void horizontal_axes(const Vector3& up, Vector3& right, Vector3& front) {
  front = std::abs(up.z()) < 0.9 ? Vector3(0, 0, 1) : Vector3(0, -1, 0);
  front = (front - up * up.dot(front)).normalized();
  right = up.cross(front);
}

/// The plane that bodies fall onto: the highest under the box among planes that face up.
std::optional<Eigen::Vector4d> floor_under(const Scene& scene, const Vector3& up, const Box& box) {
  std::optional<Eigen::Vector4d> best;
  double best_height = -1e300;
  for (const Boundary& boundary : scene.boundaries) {
    if (boundary.shape.kind != Shape::Kind::plane) continue;
    const Vector3 normal = boundary.shape.normal.normalized();
    if (normal.dot(up) < 0.7) continue;
    const Vector3 middle = box.empty() ? Vector3::Zero() : box.centre();
    const double down = (normal.dot(middle) - boundary.shape.offset) / normal.dot(up);
    if (down < 0 || -down < best_height) continue;
    best_height = -down;
    best = Eigen::Vector4d(normal.x(), normal.y(), normal.z(), boundary.shape.offset);
  }
  return best;
}

/// `legend`: share of the picture's width, at its right, that the subject leaves free.
View frame(const std::vector<Vector3>& points, const Box& subject, const Vector3& up, double aspect,
           double legend) {
  View view;
  view.aspect = aspect;
  view.tangent = std::tan(0.5 * 32 * degree);
  Vector3 right, front;
  horizontal_axes(up, right, front);
  // A long body is seen from its side.
  const Vector3 size = subject.high - subject.low;
  if (std::abs(size.dot(front)) > 1.6 * std::abs(size.dot(right))) {
    const Vector3 turned = right;
    right = -front;
    front = turned;
  }
  const double azimuth = 30 * degree, elevation = 14 * degree;
  const Vector3 towards = std::cos(elevation) * (std::sin(azimuth) * right + std::cos(azimuth) * front) +
                          std::sin(elevation) * up;
  const double radius = std::max(subject.radius(), 1e-6);
  Vector3 target = subject.centre();
  double distance = 3 * radius / (filled * view.tangent * std::min(1.0, aspect));
  look(view, -towards, up);
  for (int i = 0; i < 40; ++i) {
    view.eye = target + distance * towards;
    const Extent seen = extent(view, points);
    const double reach = 0.5 * std::max((seen.right - seen.left) / (1 - legend), seen.top - seen.bottom);
    target +=
        0.5 * distance * view.tangent *
        ((seen.left + seen.right + 2 * legend) * aspect * view.right + (seen.bottom + seen.top) * view.up);
    distance = std::max(distance * (0.5 + 0.5 * reach / filled), 1.2 * radius);
  }
  view.eye = target + distance * towards;
  return view;
}

} // namespace

Vector3 View::project(const Vector3& world, unsigned width, unsigned height) const {
  const Vector3 d = world - eye;
  const double depth = d.dot(forward);
  const double x = d.dot(right) / (depth * tangent * aspect), y = d.dot(up) / (depth * tangent);
  return {0.5 * (1 + x) * width, 0.5 * (1 - y) * height, depth};
}

Eigen::Matrix4d View::world_to_clip(const Eigen::Vector2d& jitter) const {
  const double endless = 1 - 2 * 0.48e-6; // just short of 1, so that infinity is not clipped
  Eigen::Matrix4d clip;
  clip.row(0) << right.transpose() / (tangent * aspect), -right.dot(eye) / (tangent * aspect);
  clip.row(1) << up.transpose() / tangent, -up.dot(eye) / tangent;
  clip.row(3) << forward.transpose(), -forward.dot(eye);
  clip.row(2) = endless * clip.row(3);
  clip(2, 3) -= 2 * near;
  clip.row(0) += jitter.x() * clip.row(3);
  clip.row(1) += jitter.y() * clip.row(3);
  return clip;
}

Stage arrange(const Scene& scene, const std::vector<Vector3>& points, const std::vector<Box>& obstacles) {
  Stage stage;
  const Vector3 gravity = scene.simulation.gravity;
  const bool falls = gravity.norm() > 1e-12;
  if (falls) stage.up = -gravity.normalized();
  const Vector3& up = stage.up;

  std::vector<Vector3> held = points;
  if (held.empty()) held = {Vector3::Constant(-0.5), Vector3::Constant(0.5)};
  Box bodies;
  for (const Vector3& point : held) bodies.add(point);
  const double size = std::max(bodies.radius(), 1e-6);
  const std::optional<Eigen::Vector4d> floor = floor_under(scene, up, bodies);
  if (falls && floor) { // all of them, fallen onto it as they are
    double down = 1e300;
    const Vector3 normal = floor->head<3>();
    for (const Vector3& point : held)
      down = std::min(down, (normal.dot(point) - (*floor)[3]) / normal.dot(up));
    const std::size_t count = held.size();
    if (down > 0 && down < 20 * size)
      for (std::size_t i = 0; i < count; ++i) held.push_back(held[i] - down * up);
  }
  for (const Box& obstacle : obstacles)
    if (obstacle.radius() < 2.5 * size && (obstacle.centre() - bodies.centre()).norm() < 5 * size)
      for (int i = 0; i < 8; ++i) held.push_back(obstacle.corner(i));
  for (const Vector3& point : held) stage.subject.add(point);
  if (scene.render.ground && !floor) {
    double lowest = 1e300;
    for (int i = 0; i < 8; ++i) lowest = std::min(lowest, up.dot(stage.subject.corner(i)));
    stage.ground = Eigen::Vector4d(up.x(), up.y(), up.z(), lowest);
  }

  const bool field = scene.render.color != "body";
  const double legend =
      field ? std::min(14 * legend_unit(scene.render.size[1]) / scene.render.size[0], 0.3) : 0;
  const double aspect = double(scene.render.size[0]) / scene.render.size[1];
  if (scene.render.camera) {
    const Camera& camera = *scene.render.camera;
    stage.view.eye = camera.eye;
    stage.view.aspect = aspect;
    stage.view.tangent = std::tan(0.5 * camera.fov * degree);
    look(stage.view, camera.look - camera.eye, camera.up);
  } else {
    stage.view = frame(held, stage.subject, up, aspect, legend);
  }
  View& view = stage.view;
  view.near = std::max(0.01 * (view.eye - stage.subject.centre()).norm(), 1e-3 * stage.subject.radius());

  // From the left, behind the viewer's shoulder: faces are lit, shadows fall to the right and back.
  Vector3 side = view.right - up * up.dot(view.right);
  if (side.norm() < 1e-6) side = up.unitOrthogonal();
  side.normalize();
  Vector3 back = side.cross(up);
  if (back.dot(view.forward) > 0) back = -back;
  stage.to_sun =
      (std::sin(50 * degree) * up + std::cos(50 * degree) * (0.80 * -side + 0.60 * back)).normalized();
  return stage;
}

std::vector<Vector3> outline_at_start(const Model& model) {
  std::vector<Vector3> points;
  const auto add = [&](const std::vector<Vector3>& from) {
    const std::size_t step = from.size() / 4000 + 1;
    for (std::size_t i = 0; i < from.size(); i += step) points.push_back(from[i]);
    for (int axis = 0; axis < 3 && !from.empty(); ++axis) { // the outermost are among them
      const auto less = [axis](const Vector3& a, const Vector3& b) { return a[axis] < b[axis]; };
      const auto [low, high] = std::minmax_element(from.begin(), from.end(), less);
      points.push_back(*low - 0.5 * model.spacing * Vector3::Unit(axis));
      points.push_back(*high + 0.5 * model.spacing * Vector3::Unit(axis));
    }
  };
  add(model.position);
  for (const BodyModel& body : model.bodies)
    if (body.surface) add(body.surface->vertices);
  return points;
}

Eigen::Matrix4d motion_matrix(const Motion& motion, double time) {
  const double elapsed = std::max(std::min(time, motion.end) - motion.start, 0.0);
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  const Matrix3 turn = Eigen::AngleAxisd(motion.rate * elapsed, motion.axis.normalized()).toRotationMatrix();
  matrix.topLeftCorner<3, 3>() = turn;
  matrix.topRightCorner<3, 1>() = motion.about - turn * motion.about + motion.velocity * elapsed;
  return matrix;
}

} // namespace pliant::gl
