// V11: bars in finite tension and compression, solved by the engine, against the curves that the program
// draws.
#include "engine/model/energy_density.h"
#include "engine/report/stress_curve.h"
#include "tests/laws/materials.h"

namespace pliant::test {
namespace {

constexpr double spacing = 0.1, young = 1e5;
constexpr int length = 16, layers = 7;

/// Uniaxial, at stretch s.
StressPoint point_of(const StressFunction& stress, double s) {
  std::vector<double> way;
  for (int k = 0; k <= 5; ++k) way.push_back(1 + (s - 1) * k / 5);
  return stress_points(StressTest::uniaxial, stress, way, young).back();
}
StressPoint point_of(const Material& material, const BondSet& bonds, double s) {
  const EnergyDensity density(material, bonds);
  return point_of([&](const Matrix3& f) { return density.stress(f); }, s);
}

struct Drawn {
  double stress = 0, stretch = 0; ///< Pa; of the middle
};

/// A bar whose ends are drawn apart and, as the curve says, narrowed; at rest: a step so long that inertia
/// does not matter. Near its ends it is stretched otherwise than in its middle.
Drawn draw(Device& device, const Material& material, double s, double lateral) {
  Stage stage(lattice(length, layers, layers, spacing), spacing, material, 1e3);
  const Points rest = stage.model.position;
  Vector3 centre = Vector3::Zero();
  for (const Vector3& x : rest) centre += x / static_cast<double>(rest.size());
  const double end = (length - 1) * spacing / 2;
  stage.move([&](const Vector3& x) -> Vector3 {
    return centre + Vector3(s, lateral, lateral).cwiseProduct(x - centre);
  });
  stage.hold([&](const Vector3& y) { return std::abs(y.x() - centre.x()) > s * end - 1e-6; });
  stage.scene.solver.method = "newton";
  stage.scene.solver.preconditioner = "multilevel";
  stage.scene.solver.tolerance = 1e-4;
  stage.scene.solver.iterations = 2000;
  Simulation simulation(device, stage.scene, stage.model);
  simulation.step();
  for (const StepStatistics& row : simulation.take_statistics()) EXPECT_NE(row.reason, StopReason::cap);
  const Points y = simulation.positions();
  const std::vector<Vector3> force = simulation.elastic_forces(y);
  double pulled = 0, along = 0, along2 = 0;
  for (std::size_t i = 0; i < y.size(); ++i) {
    const double x = rest[i].x() - centre.x();
    if (x > end - spacing / 2) pulled -= force[i].x();
    if (std::abs(x) > length * spacing / 8) continue;
    along += x * (y[i].x() - centre.x()), along2 += x * x;
  }
  return {pulled / (layers * spacing * layers * spacing), along / along2};
}

SimulationSettings settings_of(double horizon) {
  SimulationSettings settings;
  settings.spacing = spacing;
  settings.horizon = horizon;
  return settings;
}

std::vector<NamedMaterial> all_materials() {
  std::vector<NamedMaterial> all = some_materials(young, 0.25);
  all.push_back({"neo-hookean exact", formed("neo-hookean", "exact", young, 0.25)});
  return all;
}

// What is left: moments of edges and corners, which the fourth ones are only nearly matched at (1 % of E at
// five layers). The exact St. Venant-Kirchhoff law also against P = E s (s^2 - 1) / 2.
TEST(FiniteTension, BarsFollowTheirCurves) {
  const auto device = open_double();
  for (const auto& [name, material] : all_materials())
    for (const double s : {0.8, 1.2, 1.6, 2.0}) {
      const BondSet bonds = lattice_neighbourhood(settings_of(1.87), material);
      const Drawn bar = draw(*device, material, s, point_of(material, bonds, s).lateral);
      const double own = point_of(material, bonds, bar.stretch).stress;
      const std::string at = name + ", stretch " + std::to_string(bar.stretch).substr(0, 5);
      expect_below(at + ": stress over its curve's, less 1", std::abs(bar.stress / own - 1), 0.02);
      if (name != "stvk exact") continue;
      const double closed = young * bar.stretch * (bar.stretch * bar.stretch - 1) / 2;
      expect_below(at + ": over the closed formula's, less 1", std::abs(bar.stress / closed - 1), 0.01);
    }
}

// 80 bonds (a horizon of 2.6 spacings) are the continuum within 2 % from 0.8 to 2 times the length. With 26,
// whose moments are its own only up to the fourth, and at half the length, what they are off is printed.
TEST(FiniteTension, LatticesNearTheContinuum) {
  for (const auto& [name, material] : some_materials(young, 0.25))
    for (const double s : {0.5, 0.8, 1.2, 1.6, 2.0}) {
      const double continuum = point_of(material, sphere_neighbourhood(material, 12), s).stress;
      const std::string at = name + ", stretch " + std::to_string(s).substr(0, 3);
      for (const double horizon : {1.87, 2.6}) {
        const BondSet bonds = lattice_neighbourhood(settings_of(horizon), material);
        const double off = std::abs(point_of(material, bonds, s).stress / continuum - 1);
        const std::string what =
            at + ", " + std::to_string(bonds.bond.size()) + " bonds: stress over the continuum's, less 1";
        if (horizon > 2 && s > 0.7)
          expect_below(what, off, 0.02);
        else
          report(what, off);
      }
    }
}

// Both forms, and the paper's (g = h = A_1 by its Eq. 26), against mu (s - 1/s) + lambda ln J / s. Near rest
// they are comparable; far from it what each is away is printed, not judged.
TEST(FiniteTension, NeoHookeanVariantsAgainstTheClosedFormula) {
  Material paper = basis_of(young, 0.25, {{"A1", 1}}, {{"A1", 1}});
  paper.calibration = "xu2018";
  const std::vector<NamedMaterial> variants = {{"exact", formed("neo-hookean", "exact", young, 0.25)},
                                               {"bonds", formed("neo-hookean", "bonds", young, 0.25)},
                                               {"A1, xu2018", paper}};
  for (const double s : {0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 1.05, 1.1, 1.2, 1.4, 1.6, 1.8, 2.0}) {
    const double closed =
        point_of(
            [&](const Matrix3& f) { return classical_stress(ClassicalLaw::neo_hookean, young, 0.25, f); }, s)
            .stress;
    for (const auto& [name, material] : variants) {
      const double off =
          point_of(material, lattice_neighbourhood(settings_of(1.87), material), s).stress / closed - 1;
      const std::string what =
          name + ", stretch " + std::to_string(s).substr(0, 4) + ": over the closed formula's, less 1";
      report(what, off);
      if (std::abs(s - 1) < 0.06) {
        EXPECT_LT(std::abs(off), name == "A1, xu2018" ? 0.15 : 0.06) << what;
      }
    }
  }
}

} // namespace
} // namespace pliant::test
