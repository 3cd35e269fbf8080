// A bar pulled at its held ends returns the Young's modulus and Poisson's ratio that were typed in, far from
// the ends.
//
// Relaxation: implicit Euler with a long step damps every mode, so steps of the engine itself reach the
// static state. In float, what is left is the rounding of positions: eps |y| / spacing = 2e-6 of a bond's
// strain (|y| <= 1.5 m, spacing 0.1 m), 2e-4 of the strain of 1e-2 used there; the slow modes, in which such
// errors collect, amplify it by at most a few times: 5e-3 is asked for. The corotated law is linear in
// tension, so the strain does not matter.
#include "engine/model/energy_density.h"
#include "engine/report/stress_curve.h"
#include "tests/support/bodies.h"

namespace pliant::test {
namespace {

constexpr double spacing = 0.1, young = 2e5;

struct Measured {
  double young = 0, poisson = 0, rest = 0; // young: relative to what was typed
  double strain = 0;                       // of the middle
};

Measured pull(Device& device, const std::string& law, int length, int layers, double poisson, double strain) {
  Stage stage(lattice(length, layers, layers, spacing), spacing, material_of(law, young, poisson), 0.05);
  const Points rest = stage.model.position;
  Vector3 centre = Vector3::Zero();
  for (const Vector3& x : rest) centre += x / static_cast<double>(rest.size());
  const double end = (length - 1) * spacing / 2;
  stage.move([&](const Vector3& x) -> Vector3 { return x + Vector3(strain * (x.x() - centre.x()), 0, 0); });
  stage.hold(
      [&](const Vector3& y) { return std::abs(y.x() - centre.x()) > end * (1 + strain) - spacing / 2; });
  Simulation simulation(device, stage.scene, stage.model);
  for (int k = 0; k < 15; ++k) simulation.step();
  const Points y = simulation.positions();
  const std::vector<Vector3> force = simulation.elastic_forces(y);
  // Fits of the displacement over the middle.
  double along = 0, along2 = 0, across = 0, across2 = 0, pulled = 0;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    const Vector3 x = rest[i] - centre, u = y[i] - rest[i];
    if (x.x() > end - spacing / 2) pulled -= force[i].x();
    if (std::abs(x.x()) > length * spacing / 8) continue;
    along += x.x() * u.x(), along2 += x.x() * x.x();
    across += x.y() * u.y() + x.z() * u.z(), across2 += x.y() * x.y() + x.z() * x.z();
  }
  const double e = along / along2, area = layers * spacing * layers * spacing;
  return {pulled / area / e / young, -across / across2 / e,
          largest(simulation.velocities()) * 0.05 / (std::abs(e) * length * spacing), e};
}

class Tension : public OnEachDevice {};

TEST_P(Tension, CorotatedBarReturnsWhatWasTyped) {
  const bool gl = GetParam().gl();
  const auto open = device();
  for (const int layers : gl ? std::vector<int>{3} : std::vector<int>{3, 5})
    for (const double poisson : gl ? std::vector<double>{0.25} : std::vector<double>{0.0, 0.25, 0.4}) {
      const Measured bar = pull(*open, "corotated", gl ? 20 : 30, layers, poisson, is_double() ? 1e-3 : 1e-2);
      const std::string name =
          "n = " + std::to_string(layers) + ", ratio " + std::to_string(poisson).substr(0, 4);
      expect_below(name + ": |E / E0 - 1|", std::abs(bar.young - 1), limit(0.002, 0.005));
      expect_below(name + ": |nu - nu0|", std::abs(bar.poisson - poisson), limit(0.002, 0.005));
      report(name + ": motion left, of the elongation, a step", bar.rest);
    }
}

// The ordinary law needs fourth moments, which edges cannot give: 1 % and 0.005 for five layers. Float adds
// its rounding as above.
TEST_P(Tension, OrdinaryBarReturnsWhatWasTyped) {
  if (GetParam().gl())
    GTEST_SKIP() << "five layers take too long on a GL that is software; float runs on OpenMP";
  const auto open = device();
  for (const double poisson : {0.0, 0.25, 0.4}) {
    const Measured bar = pull(*open, "ordinary", 30, 5, poisson, 1e-3);
    const std::string name = "ordinary, n = 5, ratio " + std::to_string(poisson).substr(0, 4);
    expect_below(name + ": |E / E0 - 1|", std::abs(bar.young - 1), limit(0.01, 0.015));
    expect_below(name + ": |nu - nu0|", std::abs(bar.poisson - poisson), limit(0.005, 0.01));
  }
}

// The exact neo-Hookean law, near rest, where its curve bends by 1.5 of the strain.
TEST(NeoHookeanTension, BarReturnsWhatWasTyped) {
  const auto open = open_double();
  for (const int layers : {3, 5})
    for (const double poisson :
         layers == 3 ? std::vector<double>{0.0, 0.25, 0.45} : std::vector<double>{0.4}) {
      const Measured bar = pull(*open, "neo-hookean", 30, layers, poisson, 1e-4);
      const std::string name =
          "neo-hookean, n = " + std::to_string(layers) + ", ratio " + std::to_string(poisson).substr(0, 4);
      expect_below(name + ": |E / E0 - 1|", std::abs(bar.young - 1), 0.002);
      expect_below(name + ": |nu - nu0|", std::abs(bar.poisson - poisson), 0.002);
    }
}

// An affine deformation of all has the energy of the formula, whatever its orientation: no weight enters it.
TEST(NeoHookeanTension, AffineEnergyIsTheFormula) {
  const auto open = open_double();
  Matrix3 sheared;
  sheared << 1.2, 0.3, 0, -0.1, 0.8, 0.2, 0, 0.1, 1.1;
  const Matrix3 turned = Eigen::AngleAxisd(2.5, Vector3(1, 2, -2) / 3).toRotationMatrix();
  const Material material = material_of("neo-hookean", young, 0.3);
  Stage stage(lattice(5, 4, 4, spacing), spacing, material, 0.05);
  Simulation simulation(*open, stage.scene, stage.model);
  const EnergyDensity density(material, {{Vector3(1, 0, 0)}, {1.0}, {}});
  const Points rest = simulation.positions();
  for (const Matrix3& f :
       {sheared, Matrix3(turned * sheared), Matrix3(turned * (Matrix3::Identity() + 1e-5 * sheared)),
        Matrix3(Vector3(-0.5, 1, 1).asDiagonal())}) {
    Points y;
    for (const Vector3& x : rest) y.push_back(f * x);
    const double wanted = density.value(f) * std::pow(spacing, 3) * static_cast<double>(rest.size());
    expect_below("affine: |energy / formula - 1|", std::abs(simulation.elastic_energy(y) / wanted - 1),
                 f.isApprox(turned, 1e-3) ? 1e-5 : 1e-12);
  }
}

// Far from rest, at 0.8 and 1.2 of its length: the stress and the thickness of the homogeneous test at the
// stretch that the middle has, found without the engine.
TEST(HyperelasticTension, BarFollowsItsCurve) {
  const auto open = open_double();
  const struct {
    const char* law;
    int layers;
    double limit; // laws over bonds: the side's neighbourhoods have other weights than the middle's
  } laws[] = {{"neo-hookean", 3, 0.005}, {"stvk", 5, 0.02}, {"ordinary", 5, 0.02}};
  for (const auto& [law, layers, limit] : laws)
    for (const double poisson : {0.25, 0.4})
      for (const double strain : {-0.2, 0.2}) {
        // Short enough not to buckle, long enough that its ends are far.
        const Measured bar = pull(*open, law, (strain < 0 ? 4 : 6) * layers, layers, poisson, strain);
        const Material material = material_of(law, young, poisson);
        SimulationSettings settings;
        settings.spacing = spacing;
        const EnergyDensity density(material, lattice_neighbourhood(settings, material));
        const double s = 1 + bar.strain;
        const StressPoint wanted = stress_points(
            StressTest::uniaxial, [&](const Matrix3& f) { return density.stress(f); }, {s}, young)[0];
        const std::string name = std::string(law) + " at s = " + std::to_string(s).substr(0, 6) + ", ratio " +
                                 std::to_string(poisson).substr(0, 4);
        expect_below(name + ": |stress / wanted - 1|",
                     std::abs(bar.young * young * bar.strain / wanted.stress - 1), limit);
        expect_below(name + ": |thickness - wanted|", std::abs(1 - bar.poisson * bar.strain - wanted.lateral),
                     limit / 2);
      }
}

INSTANTIATE_TEST_SUITE_P(Physics, Tension, testing::ValuesIn(device_choices()), ChoiceName());

} // namespace
} // namespace pliant::test
