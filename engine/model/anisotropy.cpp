// Directions and strengths of bonds.
#include "engine/model/anisotropy.h"

#include "engine/core/error.h"

#include <Eigen/Eigenvalues>
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

/// Integral over [0, pi/2] by Gauss's rule of eight points on panels that halve towards 0, where |Sigma N|
/// bends within an angle of the ratio of two strengths.
template <class Function> double quarter_turn(Function f) {
  constexpr double node[] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
  constexpr double weight[] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                               0.1012285362903763};
  double sum = 0, high = std::numbers::pi / 2;
  for (int panel = 0; panel < 14; ++panel) {
    const double low = panel == 13 ? 0 : high / 2, half = (high - low) / 2, middle = (high + low) / 2;
    for (int k = 0; k < 4; ++k)
      sum += half * weight[k] * (f(middle - half * node[k]) + f(middle + half * node[k]));
    high = low;
  }
  return sum;
}

/// Mean of f(|Sigma N|) over the sphere. The poles lie along the greatest strength, longitudes count from the
/// least.
template <class Function> double sphere_mean(Vector3 strengths, Function f) {
  std::sort(strengths.begin(), strengths.end());
  const Vector3 squares = strengths.cwiseAbs2();
  const double sum = quarter_turn([&](double latitude) {
    const double up = std::sin(latitude), out = std::cos(latitude);
    return out * quarter_turn([&](double longitude) {
             const double l = std::cos(longitude), m = std::sin(longitude);
             return f(
                 std::sqrt(squares[2] * up * up + out * out * (squares[0] * l * l + squares[1] * m * m)));
           });
  });
  return sum / (std::numbers::pi / 2);
}

/// Over a circle, of an ellipse.
template <class Function> double circle_mean(double one, double other, Function f) {
  const double least = std::min(one, other), most = std::max(one, other);
  return quarter_turn(
             [&](double angle) { return f(std::hypot(most * std::sin(angle), least * std::cos(angle))); }) /
         (std::numbers::pi / 2);
}

/// Of the directions in the plane that a flat neighbourhood fills best.
double mean_in_plane(const Model& model, std::size_t i, const Matrix3& directions, const Vector3& strengths) {
  Matrix3 spread = Matrix3::Zero();
  for (std::uint32_t b = model.bonds.begin[i]; b < model.bonds.begin[i + 1]; ++b) {
    const Vector3 xi = (model.reference[model.bonds.neighbour[b]] - model.reference[i]).normalized();
    spread += xi * xi.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3> solver(spread);
  const Matrix3& axes = model.bodies[model.body[i]].axes;
  Eigen::Matrix<double, 3, 2> along = axes * solver.eigenvectors().rightCols<2>();
  along = strengths.asDiagonal() * (directions * along);
  const Eigen::Vector2d squares =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(along.transpose() * along).eigenvalues();
  return mean_strength(std::sqrt(squares[0]), std::sqrt(squares[1]));
}

} // namespace

double mean_strength(const Vector3& strengths) {
  return sphere_mean(strengths, [](double size) { return size; });
}

double mean_softness(const Vector3& strengths) {
  return mean_strength(strengths) * sphere_mean(strengths, [](double size) { return 1 / size; });
}

double mean_strength(double one, double other) {
  return circle_mean(one, other, [](double size) { return size; });
}

double mean_softness(double one, double other) {
  return mean_strength(one, other) * circle_mean(one, other, [](double size) { return 1 / size; });
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

std::vector<double> bond_strengths(const Scene& scene, const Model& model) {
  std::vector<double> mean(model.constants.size(), 0);
  bool any = false;
  for (std::size_t i = 0; i < model.count(); ++i) {
    const Anisotropy& anisotropy = typed_material(scene, model, i).anisotropy;
    if (!anisotropy.given || mean[model.material[i]] > 0) continue;
    check_anisotropy(anisotropy);
    mean[model.material[i]] = mean_strength(anisotropy.strengths);
    any = true;
  }
  if (!any) return {};
  std::vector<double> strength(model.bonds.count(), 1.0);
#pragma omp parallel for schedule(static)
  for (std::size_t i = 0; i < model.count(); ++i) {
    const Anisotropy& anisotropy = typed_material(scene, model, i).anisotropy;
    if (!anisotropy.given) continue;
    const BodyModel& body = model.bodies[model.body[i]];
    const Matrix3 directions = directions_at(anisotropy, body.origin + body.axes * model.reference[i]);
    const double usual = body.thickness > 0 ? mean_in_plane(model, i, directions, anisotropy.strengths)
                                            : mean[model.material[i]];
    for (std::uint32_t b = model.bonds.begin[i]; b < model.bonds.begin[i + 1]; ++b) {
      const Vector3 xi = model.reference[model.bonds.neighbour[b]] - model.reference[i];
      strength[b] = strength_along((body.axes * xi).normalized(), directions, anisotropy.strengths, usual);
    }
  }
  return strength;
}

} // namespace pliant
