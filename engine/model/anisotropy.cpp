// Directions and strengths of bonds.
#include "engine/model/anisotropy.h"

#include "engine/core/error.h"

#include <Eigen/Geometry>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pliant {

namespace {

constexpr double degree = std::numbers::pi / 180;
/// Of the dot products of directions: typed to six digits, they may miss a right angle by as much.
constexpr double orthonormal = 1e-5;
/// A ratio beyond it leaves a direction with no stiffness that single precision can tell from the others'.
constexpr double largest_ratio = 1e3;

/// Mean of f(N) over the sphere, f even in each component: the midpoint rule in N_z and in the angle about z
/// over an eighth of the sphere. N_z is graded as t^3, since f may vary fast near N_z = 0.
template <class Function> double sphere_mean(Function f) {
  constexpr int rings = 200, spokes = 200;
  double sum = 0, weight = 0;
  for (int k = 0; k < rings; ++k) {
    const double t = (k + 0.5) / rings, z = t * t * t, r = std::sqrt(1 - z * z), w = 3 * t * t;
    double ring = 0;
    for (int l = 0; l < spokes; ++l) {
      const double angle = (l + 0.5) / spokes * std::numbers::pi / 2;
      ring += f(Vector3(r * std::cos(angle), r * std::sin(angle), z));
    }
    sum += w * ring / spokes;
    weight += w;
  }
  return sum / weight;
}

} // namespace

double mean_strength(const Vector3& strengths) {
  return sphere_mean([&](const Vector3& n) { return strengths.cwiseProduct(n).norm(); });
}

double mean_softness(const Vector3& strengths) {
  return mean_strength(strengths) *
         sphere_mean([&](const Vector3& n) { return 1 / strengths.cwiseProduct(n).norm(); });
}

void check_anisotropy(const Anisotropy& anisotropy) {
  const Vector3& sigma = anisotropy.strengths;
  if (!(sigma.minCoeff() > 0) || !sigma.allFinite())
    throw Error(ExitCode::usage,
                fmt::format("the strengths are [{}, {}, {}]; each must be above 0, because bonds "
                            "without stiffness hold nothing together",
                            sigma.x(), sigma.y(), sigma.z()));
  if (sigma.maxCoeff() > largest_ratio * sigma.minCoeff())
    throw Error(
        ExitCode::usage,
        fmt::format("the strengths are [{}, {}, {}]; the largest must be at most {:g} times the least",
                    sigma.x(), sigma.y(), sigma.z(), largest_ratio));
  const Matrix3 product = anisotropy.directions * anisotropy.directions.transpose();
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b <= a; ++b) {
      if (std::abs(product(a, b) - (a == b)) <= orthonormal) continue;
      throw Error(
          ExitCode::usage,
          a == b ? fmt::format("direction {} has length {:.6g}; the directions must be unit vectors", a + 1,
                               std::sqrt(product(a, a)))
                 : fmt::format("directions {} and {} meet at {:.4g} degrees; the three directions must be "
                               "at right angles",
                               b + 1, a + 1,
                               std::acos(std::clamp(product(a, b) / std::sqrt(product(a, a) * product(b, b)),
                                                    -1.0, 1.0)) /
                                   degree));
    }
}

Matrix3 directions_at(const Anisotropy& anisotropy, const Vector3& place) {
  check_anisotropy(anisotropy);
  if (!anisotropy.around)
    return anisotropy.directions *
           Eigen::AngleAxisd(anisotropy.rotate_degrees * degree, anisotropy.rotate_axis)
               .toRotationMatrix()
               .transpose();
  const Vector3 axis = anisotropy.around_axis.normalized(), away = place - anisotropy.around_through;
  Vector3 radial = away - away.dot(axis) * axis;
  // On the axis itself any radius will do.
  if (!(radial.norm() > 1e-9 * (away.norm() + 1e-300))) radial = axis.unitOrthogonal();
  radial.normalize();
  Matrix3 rows;
  rows << radial.transpose(), axis.cross(radial).transpose(), axis.transpose();
  return rows;
}

double strength_along(const Vector3& direction, const Matrix3& directions, const Vector3& strengths,
                      double mean) {
  return strengths.cwiseProduct(directions * direction).norm() / mean;
}

std::vector<double> bond_strengths(const Model& model, const std::vector<Material>& materials) {
  std::vector<double> mean(materials.size(), 0);
  bool any = false;
  for (const std::uint32_t m : model.material) {
    if (!materials[m].anisotropy.given || mean[m] > 0) continue;
    check_anisotropy(materials[m].anisotropy);
    mean[m] = mean_strength(materials[m].anisotropy.strengths);
    any = true;
  }
  if (!any) return {};
  std::vector<double> strength(model.bonds.count(), 1.0);
#pragma omp parallel for schedule(static)
  for (std::size_t i = 0; i < model.count(); ++i) {
    const Anisotropy& anisotropy = materials[model.material[i]].anisotropy;
    if (!anisotropy.given) continue;
    const BodyModel& body = model.bodies[model.body[i]];
    const Matrix3 directions = directions_at(anisotropy, body.origin + body.axes * model.reference[i]);
    for (std::uint32_t b = model.bonds.begin[i]; b < model.bonds.begin[i + 1]; ++b) {
      const Vector3 xi = model.reference[model.bonds.neighbour[b]] - model.reference[i];
      strength[b] = strength_along((body.axes * xi).normalized(), directions, anisotropy.strengths,
                                   mean[model.material[i]]);
    }
  }
  return strength;
}

} // namespace pliant
