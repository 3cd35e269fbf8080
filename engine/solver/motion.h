// Rigid motions of held particles and obstacles, evaluated in double.
#pragma once

#include "engine/scene/scene.h"

#include <Eigen/Geometry>

#include <algorithm>

namespace pliant {

/// x(t) = rotation x0 + shift, world coordinates.
struct RigidMap {
  Matrix3 rotation = Matrix3::Identity();
  Vector3 shift = Vector3::Zero();
  Vector3 operator()(const Vector3& x) const { return rotation * x + shift; }
};

/// Whether what the motion moved is free of it by time t: particles move on by themselves, an obstacle is
/// gone.
inline bool released(const Motion& motion, double time) {
  return motion.release.value_or(false) && time > motion.end;
}

/// Where a motion has carried things by time t: it starts at `start` and stands still after `end`.
inline RigidMap motion_at(const Motion& motion, double time) {
  const double elapsed = std::max(std::min(time, motion.end) - motion.start, 0.0);
  RigidMap map;
  if (motion.rate != 0)
    map.rotation = Eigen::AngleAxisd(motion.rate * elapsed, motion.axis.normalized()).toRotationMatrix();
  map.shift = motion.about - map.rotation * motion.about + motion.velocity * elapsed;
  return map;
}

} // namespace pliant
