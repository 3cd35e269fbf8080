// A bar pulled at its held ends returns the Young's modulus and Poisson's ratio that were typed in, far from
// the ends.
//
// Relaxation: implicit Euler with a long step damps every mode, so steps of the engine itself reach the
// static state. In float, what is left is the rounding of positions: eps |y| / spacing = 2e-6 of a bond's
// strain (|y| <= 1.5 m, spacing 0.1 m), 2e-4 of the strain of 1e-2 used there; the slow modes, in which such
// errors collect, amplify it by at most a few times: 5e-3 is asked for. The corotated law is linear in
// tension, so the strain does not matter.
#include "tests/support/bodies.h"

namespace pliant::test {
namespace {

constexpr double spacing = 0.1, young = 2e5;

struct Measured {
  double young = 0, poisson = 0, rest = 0; // young: relative to what was typed
};

Measured pull(Device& device, const std::string& law, int length, int layers, double poisson, double strain) {
  Stage stage(lattice(length, layers, layers, spacing), spacing, material_of(law, young, poisson), 0.05);
  const Points rest = stage.model.position;
  Vector3 centre = Vector3::Zero();
  for (const Vector3& x : rest) centre += x / static_cast<double>(rest.size());
  const double end = (length - 1) * spacing / 2;
  stage.move([&](const Vector3& x) -> Vector3 { return x + Vector3(strain * (x.x() - centre.x()), 0, 0); });
  stage.hold([&](const Vector3& y) { return std::abs(y.x() - centre.x()) > end; });
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
          largest(simulation.velocities()) * 0.05 / (e * length * spacing)};
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

INSTANTIATE_TEST_SUITE_P(Physics, Tension, testing::ValuesIn(device_choices()), ChoiceName());

} // namespace
} // namespace pliant::test
