// What the baselines share: held particles, loads, gravity, floors, and the list of them.
#include "bench/baselines/baseline.h"

#include "engine/core/error.h"
#include "engine/solver/motion.h"

#include <Eigen/SVD>

#include <array>
#include <cmath>
#include <fmt/format.h>

namespace pliant::bench {

Baseline::Baseline(const Scene& scene, const Model& model)
    : scene_(scene), model_(model), position_(model.position), velocity_(model.velocity),
      motion_(model.count(), -1) {
  for (const Boundary& boundary : scene.boundaries)
    if (boundary.shape.kind != Shape::Kind::plane || boundary.motion.rate != 0 ||
        !boundary.motion.velocity.isZero() || boundary.motion.release)
      throw Error(
          ExitCode::usage,
          fmt::format("boundary \"{}\": the baselines know planes at rest only; take another scene, or "
                      "this one out of it",
                      boundary.name));
  for (const Held& h : model.held) motion_[h.particle] = static_cast<std::int32_t>(h.motion);
}

void Baseline::advance(double h) {
  step(h);
  time_ += h;
  if (damping_ > 0) scale_velocities(std::exp(-damping_ * h));
}

void Baseline::scale_velocities(double factor) {
  for (Vector3& v : velocity_) v *= factor;
}

bool Baseline::held(std::size_t i, double time) const {
  return motion_[i] >= 0 && !released(model_.motions[static_cast<std::size_t>(motion_[i])], time);
}

Vector3 Baseline::external_force(std::size_t i, double time) const {
  Vector3 force = model_.mass[i] * scene_.simulation.gravity;
  for (const Load& load : model_.loads)
    if (load.particle == i && time >= load.start && time < load.end) force += load.force;
  return force;
}

Vector3 Baseline::prescribed(std::size_t i, double time) const {
  return motion_at(model_.motions[static_cast<std::size_t>(motion_[i])], time)(model_.position[i]);
}

Points Baseline::inertial_target(double h) const {
  Points target(position_.size());
  for (std::size_t i = 0; i < target.size(); ++i)
    target[i] = held(i, time_ + h)
                    ? prescribed(i, time_ + h)
                    : position_[i] + h * velocity_[i] + h * h / model_.mass[i] * external_force(i, time_);
  return target;
}

void Baseline::take(const Points& next, double h) {
  for (std::size_t i = 0; i < next.size(); ++i) {
    velocity_[i] = (next[i] - position_[i]) / h;
    position_[i] = next[i];
  }
}

void Baseline::collide(double h) {
  for (const Boundary& boundary : scene_.boundaries) {
    const Vector3& n = boundary.shape.normal;
    for (std::size_t i = 0; i < position_.size(); ++i) {
      const double depth = boundary.shape.offset - n.dot(position_[i]);
      if (!(depth > 0) || held(i, time_ + h)) continue;
      position_[i] += depth * n;
      const double into = std::min(n.dot(velocity_[i]), 0.0);
      const Vector3 along = velocity_[i] - n.dot(velocity_[i]) * n;
      const double speed = along.norm();
      const double kept = !boundary.slip ? 0
                          : speed > 0    ? std::max(1 + boundary.friction * into / speed, 0.0)
                                         : 0;
      velocity_[i] = kept * along + (n.dot(velocity_[i]) - into) * n;
    }
  }
}

namespace {
constexpr std::array methods{"mass-spring", "shape-matching", "explicit", "mls", "pliant"};
} // namespace

std::span<const char* const> method_names() {
  return methods;
}

std::unique_ptr<Baseline> make_baseline(const std::string& method, const Scene& scene, const Model& model) {
  if (method == "mass-spring") return make_mass_spring(scene, model);
  if (method == "shape-matching") return make_shape_matching(scene, model);
  if (method == "explicit") return make_explicit(scene, model);
  if (method == "mls") return make_mls(scene, model);
  if (method == "pliant") return make_product(scene, model);
  throw Error(ExitCode::usage,
              fmt::format("there is no method \"{}\"; there are {}", method, fmt::join(methods, ", ")));
}

Matrix3 signed_rotation(const Matrix3& a) {
  const Eigen::JacobiSVD<Matrix3> svd(a, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3 u = svd.matrixU();
  if ((u * svd.matrixV().transpose()).determinant() < 0) u.col(2) = -u.col(2);
  return u * svd.matrixV().transpose();
}

} // namespace pliant::bench
