// Solves the homogeneous tests.
#include "engine/report/stress_curve.h"

#include "engine/core/error.h"
#include "engine/model/energy_density.h"

#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace pliant {

namespace {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
constexpr double continuation = 0.02; ///< stretch by which the solution of one point starts the next
constexpr double thinnest = 0.02;     ///< a free side shorter than that has collapsed

using Free = Eigen::VectorXd; ///< stretches of the free sides

Matrix3 gradient(StressTest test, double s, const Free& free) {
  switch (test) {
  case StressTest::uniaxial:
    return Vector3(s, free[0], free[1]).asDiagonal();
  case StressTest::equibiaxial:
    return Vector3(s, s, free[0]).asDiagonal();
  case StressTest::pure_shear:
    return Vector3(s, free[0], 1).asDiagonal();
  }
  return Matrix3::Identity();
}

/// The stresses that must vanish.
Free lateral_stress(StressTest test, const Matrix3& p) {
  switch (test) {
  case StressTest::uniaxial:
    return Eigen::Vector2d(p(1, 1), p(2, 2));
  case StressTest::equibiaxial:
    return Eigen::VectorXd::Constant(1, p(2, 2));
  case StressTest::pure_shear:
    return Eigen::VectorXd::Constant(1, p(1, 1));
  }
  return {};
}

/// Newton's method with differences. False where it finds no equilibrium near the start.
bool solve(StressTest test, const StressFunction& stress, double s, double scale, Free& free) {
  const auto residual = [&](const Free& at) { return lateral_stress(test, stress(gradient(test, s, at))); };
  for (int round = 0; round < 60; ++round) {
    const Free r = residual(free);
    if (!r.allFinite() || free.minCoeff() < thinnest) return false;
    if (r.cwiseAbs().maxCoeff() < 1e-10 * scale) return true;
    Eigen::MatrixXd slope(free.size(), free.size());
    for (Eigen::Index k = 0; k < free.size(); ++k) {
      Free up = free, down = free;
      up[k] += 1e-6, down[k] -= 1e-6;
      slope.col(k) = (residual(up) - residual(down)) / 2e-6;
    }
    Free step = slope.partialPivLu().solve(r);
    step *= std::min(1.0, 0.1 * free.minCoeff() / step.cwiseAbs().maxCoeff());
    free -= step;
  }
  return false;
}

std::vector<double> stretches_of(const StressCurveOptions& options) {
  if (!(options.from > 0) || !(options.to > options.from) || !(options.step > 0))
    throw Error(ExitCode::usage,
                fmt::format("stretches from {:g} to {:g} are none: --from is above 0 and below --to",
                            options.from, options.to));
  const auto count = static_cast<std::size_t>(std::ceil((options.to - options.from) / options.step - 1e-9));
  std::vector<double> stretches;
  for (std::size_t k = 0; k <= count; ++k)
    stretches.push_back(options.from +
                        (options.to - options.from) * static_cast<double>(k) / static_cast<double>(count));
  return stretches;
}

MaterialCurves curves_of(const Scene& scene, const Material& material, const std::vector<double>& stretches) {
  MaterialCurves result{material.name, material.law, "", material.young, material.poisson, {}};
  const EnergyDensity lattice(material, lattice_neighbourhood(scene.simulation, material)),
      continuum(material, sphere_neighbourhood(material));
  const std::optional<ClassicalLaw> classical = classical_law(material);
  if (classical) result.closed_name = classical_name(*classical);
  for (const StressTest test : {StressTest::uniaxial, StressTest::equibiaxial, StressTest::pure_shear}) {
    const auto points = [&](const StressFunction& stress) {
      return stress_points(test, stress, stretches, material.young);
    };
    StressCurve curve{test,
                      points([&](const Matrix3& f) { return lattice.stress(f); }),
                      points([&](const Matrix3& f) { return continuum.stress(f); }),
                      {}};
    if (classical)
      curve.closed = points([&](const Matrix3& f) {
        return classical_stress(*classical, material.young, material.poisson, f);
      });
    result.curves.push_back(std::move(curve));
  }
  return result;
}

} // namespace

const char* stress_test_name(StressTest test) {
  switch (test) {
  case StressTest::uniaxial:
    return "uniaxial";
  case StressTest::equibiaxial:
    return "equibiaxial";
  case StressTest::pure_shear:
    return "pure shear";
  }
  return "unknown";
}

std::vector<StressPoint> stress_points(StressTest test, const StressFunction& stress,
                                       const std::vector<double>& stretches, double scale) {
  std::vector<StressPoint> points(stretches.size(), {nothing, nothing});
  std::vector<std::size_t> order(stretches.size());
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::abs(stretches[a] - 1) < std::abs(stretches[b] - 1);
  });
  for (const bool longer : {false, true}) {
    double s = 1;
    Free free = Free::Ones(test == StressTest::uniaxial ? 2 : 1);
    bool found = true;
    for (const std::size_t k : order) {
      if ((stretches[k] > 1) != longer) continue;
      const auto parts = static_cast<int>(std::ceil(std::abs(stretches[k] - s) / continuation));
      const double start = s;
      for (int part = 1; found && part <= parts; ++part)
        found = solve(test, stress, start + (stretches[k] - start) * part / parts, scale, free);
      s = stretches[k];
      if (found && parts == 0) found = solve(test, stress, s, scale, free);
      if (!found) break;
      points[k] = {stress(gradient(test, s, free))(0, 0), free[0]};
    }
  }
  return points;
}

StressCurveReport stress_curves(const Scene& scene, const StressCurveOptions& options) {
  if (scene.flows())
    throw Error(ExitCode::usage,
                scene.file.string() +
                    ": a fluid has no stress against stretch; curves are of elastic materials");
  StressCurveReport report{scene.name, stretches_of(options), {}};
  for (const std::string& name : options.materials)
    if (!scene.material(name)) {
      std::string known;
      for (const Material& material : scene.materials) known += (known.empty() ? "" : ", ") + material.name;
      throw Error(ExitCode::usage,
                  fmt::format("{} has no material '{}'; it has {}", scene.file.string(), name, known));
    }
  for (const Material& material : scene.materials)
    if (options.materials.empty() || std::find(options.materials.begin(), options.materials.end(),
                                               material.name) != options.materials.end())
      report.materials.push_back(curves_of(scene, material, report.stretches));
  return report;
}

} // namespace pliant
