// The methods that projective peridynamics was measured against in He, Wang and Wu (2018), Figs. 1 and 4, on
// Pliant's own scenes: the same particles, bonds, masses, held particles, loads, gravity and floor. They are
// yardsticks on the CPU, in double, apart from the product's solvers.
//
//   mass-spring      springs along bonds, implicit Euler                          mass_spring.cpp
//   shape-matching   a rigid cluster a particle, position based                   shape_matching.cpp
//   explicit         Pliant's own force, symplectic Euler                         explicit.cpp
//   mls              moving-least-squares gradient, polar rotation, the same      mls.cpp
//   pliant           the product                                                  product.cpp
#pragma once

#include "engine/model/model.h"

#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace pliant::bench {

using Points = std::vector<Vector3>;

class Baseline {
public:
  /// Both must outlive it. Throws Error(usage) for a boundary that is not a plane at rest. Particles of
  /// different bodies do not touch each other.
  Baseline(const Scene& scene, const Model& model);
  virtual ~Baseline() = default;
  Baseline(const Baseline&) = delete;
  Baseline& operator=(const Baseline&) = delete;

  /// One time step of h seconds, then the damping.
  void advance(double h);
  /// s; the largest step that is stable about the rest shape, where there is one; else infinite.
  virtual double stable_step() { return std::numeric_limits<double>::infinity(); }

  const Points& positions() const { return position_; }  ///< m, world
  const Points& velocities() const { return velocity_; } ///< m/s
  double time() const { return time_; }
  /// 1/s: velocities decay by exp(-damping h) after each step of any method. It moves no equilibrium, and
  /// lets all of them come to rest alike. 0 by default.
  void set_damping(double rate) { damping_ = rate; }

protected:
  virtual void step(double h) = 0;
  virtual void scale_velocities(double factor);

  bool held(std::size_t i, double time) const;
  /// Gravity and loads on a particle, N.
  Vector3 external_force(std::size_t i, double time) const;
  /// Where a held particle is prescribed to be, m.
  Vector3 prescribed(std::size_t i, double time) const;
  /// y* = y + h v + h^2 f_ext / m; held particles where they will be at the step's end.
  Points inertial_target(double h) const;
  /// Ends a step of positions: v = (y' - y) / h, y = y'.
  void take(const Points& next, double h);
  /// Lifts particles below a floor onto it and takes the velocity into it away; Coulomb friction, or none of
  /// the slip, as the boundary says.
  void collide(double h);

  const Scene& scene_;
  const Model& model_;
  Points position_, velocity_;
  double time_ = 0;

private:
  std::vector<std::int32_t> motion_; ///< of each particle; -1: free
  double damping_ = 0;
};

/// Names for make_baseline, in the order of tables.
std::span<const char* const> method_names();
/// Throws Error(usage) for a name that is none.
std::unique_ptr<Baseline> make_baseline(const std::string& method, const Scene& scene, const Model& model);

/// The rotation nearest to a, determinant +1 also where a is inverted: the least stretch takes the sign
/// (Irving, Teran and Fedkiw 2004).
Matrix3 signed_rotation(const Matrix3& a);

std::unique_ptr<Baseline> make_mass_spring(const Scene& scene, const Model& model);
std::unique_ptr<Baseline> make_shape_matching(const Scene& scene, const Model& model);
std::unique_ptr<Baseline> make_explicit(const Scene& scene, const Model& model);
std::unique_ptr<Baseline> make_mls(const Scene& scene, const Model& model);
std::unique_ptr<Baseline> make_product(const Scene& scene, const Model& model);

} // namespace pliant::bench
