// Stress against stretch of a material: of a particle's neighbourhood on its lattice, of the continuum it
// stands for, and of the classical law in closed form where there is one.
#pragma once

#include "engine/scene/scene.h"

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// Homogeneous tests along the scene's axes; what is not held is free of stress.
enum class StressTest {
  uniaxial,    ///< diag(s, t, u), t and u free
  equibiaxial, ///< diag(s, s, t), t free
  pure_shear,  ///< diag(s, t, 1), t free: a wide strip
};
const char* stress_test_name(StressTest test);

using StressFunction = std::function<Matrix3(const Matrix3&)>; ///< P(F), Pa

struct StressPoint {
  double stress = 0;  ///< first Piola-Kirchhoff along x, Pa: force over reference area; NaN where there is no
                      ///< equilibrium on the way from s = 1
  double lateral = 0; ///< t
};
/// At each stretch, each found from the one nearer to s = 1. `scale`: Pa, of the stress whose 1e-10 is
/// nothing.
std::vector<StressPoint> stress_points(StressTest test, const StressFunction& stress,
                                       const std::vector<double>& stretches, double scale);

struct StressCurveOptions {
  std::vector<std::string> materials; ///< by name; empty: all of the scene's
  double from = 0.5, to = 2;          ///< stretches
  double step = 0.05;
};
struct StressCurve {
  StressTest test = StressTest::uniaxial;
  std::vector<StressPoint> lattice, continuum, closed; ///< closed: empty where there is none
};
struct MaterialCurves {
  std::string material, law;
  std::string closed_name; ///< empty where there is no closed formula
  double young = 0, poisson = 0;
  std::vector<StressCurve> curves;
};
struct StressCurveReport {
  std::string scene;
  std::vector<double> stretches;
  std::vector<MaterialCurves> materials;
};

/// Throws Error(usage): a material that is none of the scene's, a range that is empty.
StressCurveReport stress_curves(const Scene& scene, const StressCurveOptions& options);

std::string stress_curve_text(const StressCurveReport& report);
nlohmann::json stress_curve_json(const StressCurveReport& report);
/// curve.csv, curve.json, and for each material NAME.svg and NAME.png. Returns what it wrote.
std::vector<std::filesystem::path> write_stress_curves(const StressCurveReport& report,
                                                       const std::filesystem::path& folder);

} // namespace pliant
