// Where the picture is taken from: the scene's camera, or one that frames its bodies; and the sun beside it.
#pragma once

#include "engine/model/model.h"

#include <Eigen/Core>

namespace pliant::gl {

/// An axis-aligned box, empty until something is added.
struct Box {
  Vector3 low = Vector3::Constant(1e300), high = Vector3::Constant(-1e300); ///< m
  bool empty() const { return !(low.array() <= high.array()).all(); }
  void add(const Vector3& point) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  void add(const Box& other) {
    if (!other.empty()) add(other.low), add(other.high);
  }
  Vector3 centre() const { return 0.5 * (low + high); }
  double radius() const { return empty() ? 0 : 0.5 * (high - low).norm(); }
  Vector3 corner(int i) const {
    return {i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(), i & 4 ? high.z() : low.z()};
  }
};

/// A perspective view whose depth reaches infinity.
struct View {
  Vector3 eye = Vector3::Zero();
  Vector3 right = {1, 0, 0}, up = {0, 1, 0}, forward = {0, 0, -1}; ///< orthonormal
  double tangent = 0.36;                                           ///< of half the vertical field of view
  double aspect = 1;                                               ///< width / height
  double near = 0.01;                                              ///< m

  /// Pixel (from the upper left, first pixel's centre at 0.5) and depth along the view axis, m.
  Vector3 project(const Vector3& world, unsigned width, unsigned height) const;
  /// To clip coordinates; `jitter` in normalised device units moves the picture.
  Eigen::Matrix4d world_to_clip(const Eigen::Vector2d& jitter = Eigen::Vector2d::Zero()) const;
};

/// What does not change from picture to picture.
struct Stage {
  View view;
  Vector3 up = {0, 1, 0};     ///< against gravity, unit
  Vector3 to_sun = {0, 1, 0}; ///< unit
  Box subject;                ///< the bodies, and where they fall
  std::optional<Eigen::Vector4d>
      ground; ///< unit normal and offset, where no plane of the scene is the ground
};

/// Frames the bodies at the start and, where gravity takes them to a floor, on it: three quarters from the
/// front, the horizon level, two thirds of the picture filled. `points`: what the picture must hold of the
/// bodies; `obstacles`: boxes of boundaries, framed too where they are of the bodies' size.
Stage arrange(const Scene& scene, const std::vector<Vector3>& points, const std::vector<Box>& obstacles);

/// Some of the particles and of the carried surfaces' vertices at the start: enough to frame them.
std::vector<Vector3> outline_at_start(const Model& model);

/// x(t) = c + R (x - c) + v t as a matrix, its times clamped to the motion's.
Eigen::Matrix4d motion_matrix(const Motion& motion, double time);

} // namespace pliant::gl
