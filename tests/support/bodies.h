// Small bodies for tests of the engine through its library: lattices, held layers, loads, and what tests
// measure.
#pragma once

#include "engine/solver/simulation.h"
#include "tests/support/devices.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <vector>

namespace pliant::test {

using Points = std::vector<Vector3>;
using Where = std::function<bool(const Vector3&)>;

/// nx * ny * nz points, one corner at zero; x fastest.
inline Points lattice(int nx, int ny, int nz, double spacing) {
  Points points;
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) points.push_back(Vector3(x, y, z) * spacing);
  return points;
}

inline Material material_of(const std::string& law, double young, double poisson) {
  Material made;
  made.name = law;
  made.law = law;
  made.young = young;
  made.poisson = law == "projective" ? 0.25 : poisson;
  return made;
}

/// One body of one material, without gravity, solved tightly unless a test says otherwise.
struct Stage {
  Scene scene;
  Model model;

  Stage(const Points& points, double spacing, const Material& material, double step) {
    scene.simulation.spacing = spacing;
    scene.simulation.gravity = Vector3::Zero();
    scene.materials = {material};
    scene.solver.tolerance = 1e-6;
    time_step(step);
    model = assemble_points(points, spacing, scene.simulation.horizon, material, spacing * spacing * spacing);
  }
  /// Frames are whole steps, so a frame is one step.
  void time_step(double step) {
    scene.simulation.time_step = step;
    scene.output.fps = 1 / step;
  }
  /// Exactly so many iterations.
  void iterations(unsigned count) {
    scene.solver.iterations = count;
    scene.solver.tolerance = 0;
  }
  /// Holds the particles of the rest position chosen; returns how many.
  std::size_t hold(const Where& where, const Motion& motion = {}) {
    const auto index = static_cast<std::uint32_t>(model.motions.size());
    const std::size_t before = model.held.size();
    model.motions.push_back(motion);
    for (std::uint32_t i = 0; i < model.count(); ++i)
      if (where(model.position[i])) model.held.push_back({i, index});
    return model.held.size() - before;
  }
  /// Shares a force equally.
  void load(const Where& where, const Vector3& total) {
    std::vector<std::uint32_t> chosen;
    for (std::uint32_t i = 0; i < model.count(); ++i)
      if (where(model.position[i])) chosen.push_back(i);
    for (std::uint32_t i : chosen)
      model.loads.push_back({.particle = i, .force = total / static_cast<double>(chosen.size())});
  }
  /// Deforms the initial state; the reference stays.
  void move(const std::function<Vector3(const Vector3&)>& map) {
    for (Vector3& y : model.position) y = map(y);
  }
  std::vector<bool> free_particles() const {
    std::vector<bool> free(model.count(), true);
    for (const Held& held : model.held) free[held.particle] = false;
    return free;
  }
};

/// Single-threaded: the bodies here are small, and several tests run at a time.
inline std::unique_ptr<Device> open_alone(const DeviceChoice& choice, unsigned threads = 1) {
  DeviceRequest request;
  request.backend = choice.backend;
  request.precision = choice.precision;
  request.threads = threads;
  return open_device(request);
}
inline std::unique_ptr<Device> open_double(unsigned threads = 1) {
  return open_alone({"openmp_double", "openmp", Precision::double_precision}, threads);
}

/// Prints what was measured beside its limit, and holds it to it.
inline void expect_below(const std::string& what, double measured, double limit) {
  std::printf("  %-66s %12.4e  limit %9.2e\n", what.c_str(), measured, limit);
  EXPECT_LE(measured, limit) << what;
}
inline void expect_above(const std::string& what, double measured, double limit) {
  std::printf("  %-66s %12.4e  at least %9.2e\n", what.c_str(), measured, limit);
  EXPECT_GE(measured, limit) << what;
}
inline void report(const std::string& what, double measured) {
  std::printf("  %-66s %12.4e\n", what.c_str(), measured);
}

/// A number in [-1, 1) for each component, the same on every machine.
inline Vector3 random_vector(std::mt19937& random) {
  const auto one = [&] { return static_cast<double>(random()) / 2147483648.0 - 1; };
  const double x = one(), y = one(), z = one();
  return {x, y, z};
}

inline double largest(const std::vector<Vector3>& values) {
  double size = 0;
  for (const Vector3& v : values) size = std::max(size, v.norm());
  return size;
}
inline double largest_difference(const std::vector<Vector3>& a, const std::vector<Vector3>& b) {
  double size = 0;
  for (std::size_t i = 0; i < a.size(); ++i) size = std::max(size, (a[i] - b[i]).norm());
  return size;
}
inline double inner(const std::vector<Vector3>& a, const std::vector<Vector3>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i].dot(b[i]);
  return sum;
}
inline std::vector<Vector3> plus(const std::vector<Vector3>& a, double s, const std::vector<Vector3>& b) {
  std::vector<Vector3> sum(a);
  for (std::size_t i = 0; i < a.size(); ++i) sum[i] += s * b[i];
  return sum;
}

/// -df/dy v by central differences; held particles neither move nor count.
inline std::vector<Vector3> stiffness_times(Simulation& simulation, const std::vector<Vector3>& at,
                                            const std::vector<Vector3>& v, const std::vector<bool>& free,
                                            double step) {
  const double size = largest(v);
  std::vector<Vector3> zero(v.size(), Vector3::Zero());
  if (!(size > 0)) return zero;
  const double s = step / size;
  const std::vector<Vector3> up = simulation.elastic_forces(plus(at, s, v)),
                             down = simulation.elastic_forces(plus(at, -s, v));
  for (std::size_t i = 0; i < v.size(); ++i)
    if (free[i]) zero[i] = (down[i] - up[i]) / (2 * s);
  return zero;
}

/// Where the elastic forces balance the loads: Newton's method with conjugate gradients. Double precision
/// only.
inline std::vector<Vector3> static_solution(Simulation& simulation, const Stage& stage, int newton = 3) {
  const std::vector<bool> free = stage.free_particles();
  std::vector<Vector3> y = simulation.positions(), load(y.size(), Vector3::Zero());
  for (const Load& l : stage.model.loads) load[l.particle] += l.force;
  const double step = 1e-5 * stage.model.spacing;
  double first = 0;
  for (int round = 0; round < newton; ++round) {
    std::vector<Vector3> r = plus(load, 1, simulation.elastic_forces(y));
    for (std::size_t i = 0; i < r.size(); ++i)
      if (!free[i]) r[i].setZero();
    std::vector<Vector3> x(r.size(), Vector3::Zero()), p = r;
    double rr = inner(r, r);
    if (round == 0) first = rr;
    const double stop = std::max(1e-16 * rr, 1e-22 * first);
    for (int k = 0; k < 6000 && rr > stop; ++k) {
      const std::vector<Vector3> hp = stiffness_times(simulation, y, p, free, step);
      const double curvature = inner(p, hp);
      if (!(curvature > 0)) break;
      x = plus(x, rr / curvature, p);
      r = plus(r, -rr / curvature, hp);
      const double next = inner(r, r);
      p = plus(r, next / rr, p);
      rr = next;
    }
    y = plus(y, 1, x);
  }
  return y;
}

/// Best affine map of each particle's neighbourhood, by the base weights of its bonds.
inline Matrix3 deformation_gradient(const Model& model, const std::vector<Vector3>& y, std::uint32_t i) {
  Matrix3 yx = Matrix3::Zero(), xx = Matrix3::Zero();
  for (std::uint32_t b = model.bonds.begin[i]; b < model.bonds.begin[i + 1]; ++b) {
    const std::uint32_t j = model.bonds.neighbour[b];
    const Vector3 xi = model.reference[j] - model.reference[i];
    yx += (y[j] - y[i]) * xi.transpose();
    xx += xi * xi.transpose();
  }
  Matrix3 adjugate; // xx is symmetric and small
  const auto cofactor = [&](int r, int c) {
    const int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
    return xx(r1, c1) * xx(r2, c2) - xx(r1, c2) * xx(r2, c1);
  };
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) adjugate(c, r) = cofactor(r, c);
  return yx * adjugate / (xx.row(0).dot(adjugate.col(0)));
}

inline double determinant(const Matrix3& a) {
  return a.col(0).dot(a.col(1).cross(a.col(2)));
}

/// Root of the mean square stretch less one over all bonds.
inline double rms_bond_strain(const Model& model, const std::vector<Vector3>& y) {
  double sum = 0;
  for (std::uint32_t i = 0; i < model.count(); ++i)
    for (std::uint32_t b = model.bonds.begin[i]; b < model.bonds.begin[i + 1]; ++b) {
      const std::uint32_t j = model.bonds.neighbour[b];
      const double e = (y[j] - y[i]).norm() / (model.reference[j] - model.reference[i]).norm() - 1;
      sum += e * e;
    }
  return std::sqrt(sum / static_cast<double>(model.bonds.count()));
}

/// Tests of one body on each device.
class OnEachDevice : public testing::TestWithParam<DeviceChoice> {
protected:
  bool is_double() const { return GetParam().precision == Precision::double_precision; }
  /// A limit for each precision.
  double limit(double in_double, double in_float) const { return is_double() ? in_double : in_float; }
  std::unique_ptr<Device> device() const { return open_alone(GetParam()); }
};

} // namespace pliant::test
