// Cantilevers: static deflection, natural frequency, and a result that depends on Young's modulus as beam
// theory says but not on the iteration cap.
#include "tests/support/bodies.h"

namespace pliant::test {
namespace {

constexpr double spacing = 0.1, poisson = 0.25;

/// length free layers of n * n particles; the clamp acts at the centre of the last of two held layers.
Stage cantilever(int length, int n, double young, double step) {
  Stage stage(lattice(length + 2, n, n, spacing), spacing, material_of("corotated", young, poisson), step);
  const double first = stage.model.position.front().x();
  stage.hold([&](const Vector3& x) { return x.x() < first + 1.5 * spacing; });
  return stage;
}

double tip_deflection(const Stage& stage, const Points& rest, const Points& y) {
  double right = -1e300, sum = 0;
  int count = 0;
  for (const Vector3& x : rest) right = std::max(right, x.x());
  for (std::size_t i = 0; i < rest.size(); ++i)
    if (rest[i].x() > right - spacing / 2) sum += rest[i].y() - y[i].y(), ++count;
  return sum / (count * stage.model.spacing); // spacings, downwards
}

/// P L^3 / 3 E I + P L / k G A with Cowper's (1966) k of a rectangle, spacings; the load acts at the last
/// layer.
double timoshenko(int length, int n, double young, double force) {
  const double l = length * spacing, a = n * spacing, area = a * a, inertia = a * a * a * a / 12;
  const double k = 10 * (1 + poisson) / (12 + 11 * poisson), shear = young / (2 * (1 + poisson));
  return (force * l * l * l / (3 * young * inertia) + force * l / (k * shear * area)) / spacing;
}

TEST(Cantilever, DeflectsAsBeamTheorySays) {
  const auto open = open_double();
  const double young = 1e6;
  for (const int n : {3, 5}) {
    const int length = 10 * n;
    const double force = 1e-3 * 3 * young * std::pow(n * spacing, 4) / 12 / std::pow(length * spacing, 2);
    Stage stage = cantilever(length, n, young, 1. / 60);
    double right = -1e300;
    for (const Vector3& x : stage.model.position) right = std::max(right, x.x());
    stage.load([&](const Vector3& x) { return x.x() > right - spacing / 2; }, {0, -force, 0});
    const Points rest = stage.model.position;
    Simulation simulation(*open, stage.scene, stage.model);
    const double tip = tip_deflection(stage, rest, static_solution(simulation, stage, 2));
    const double ratio = tip / timoshenko(length, n, young, force);
    const std::string name = "n = " + std::to_string(n) + ": deflection / theory";
    if (n == 3)
      report(name, ratio);
    else
      expect_below(name + " - 1", std::abs(ratio - 1), 0.08);
  }
}

// Steps of the engine from rest under a tip load, on every device; long steps damp it to rest. Float: bending
// strains of 1e-3 against the floor's 1e-7 of a spacing a bond, which the beam's slenderness (length over
// thickness)^2 = 16 amplifies to 1e-2 at worst.
class Bending : public OnEachDevice {};

TEST_P(Bending, SettlesWhereTheStaticSolutionLies) {
  const int length = 9, n = 3;
  const double young = 1e6,
               force = 5e-3 * 3 * young * std::pow(n * spacing, 4) / 12 / std::pow(length * spacing, 2);
  Stage stage = cantilever(length, n, young, 0.1);
  double right = -1e300;
  for (const Vector3& x : stage.model.position) right = std::max(right, x.x());
  stage.load([&](const Vector3& x) { return x.x() > right - spacing / 2; }, {0, -force, 0});
  const Points rest = stage.model.position;
  const auto open = device(), reference = open_double();
  Simulation simulation(*open, stage.scene, stage.model), exact(*reference, stage.scene, stage.model);
  const double expected = tip_deflection(stage, rest, static_solution(exact, stage));
  for (int k = 0; k < 30; ++k) simulation.step();
  report("static deflection, spacings", expected);
  expect_below("relative distance from it after 30 steps",
               std::abs(tip_deflection(stage, rest, simulation.positions()) / expected - 1),
               limit(1e-3, 1e-2));
}

TEST(Cantilever, VibratesAtItsNaturalFrequency) {
  // Half a period from rest velocity: the tip swings out and returns through zero. BDF2 with 120 steps a
  // period lags by (omega h)^2 / 3 = 1e-3.
  const int length = 50, n = 5;
  const double young = 1e6, density = 1000, l = (length + 0.5) * spacing,
               a = n * spacing; // from clamp to the free face
  const double pi = std::acos(-1.0);
  const double frequency =
      1.87510407 * 1.87510407 / (2 * pi) * std::sqrt(young * a * a / 12 / density) / (l * l);
  const int steps_a_period = 80;
  Stage stage = cantilever(length, n, young, 1 / frequency / steps_a_period);
  stage.scene.solver.integrator = "bdf2";
  stage.scene.solver.tolerance = 1e-3;
  const Points rest = stage.model.position;
  const double first = rest.front().x() + spacing;
  for (std::size_t i = 0; i < rest.size(); ++i) { // Euler-Bernoulli's first mode
    const double z = std::max(rest[i].x() - first, 0.0) / l * 1.87510407, sigma = 0.73409551;
    stage.model.velocity[i].y() =
        -1e-2 * frequency * spacing * (std::cosh(z) - std::cos(z) - sigma * (std::sinh(z) - std::sin(z)));
  }
  const auto open = open_double();
  Simulation simulation(*open, stage.scene, stage.model);
  double before = 0, crossing = 0;
  for (int k = 1; k <= steps_a_period && crossing == 0; ++k) {
    simulation.step();
    const double now = tip_deflection(stage, rest, simulation.positions());
    if (k > 5 && now <= 0) crossing = (k - 1 + before / (before - now)) * simulation.time_step();
    before = now;
  }
  ASSERT_GT(crossing, 0);
  report("measured frequency, Hz", 0.5 / crossing);
  report("Euler-Bernoulli frequency, Hz", frequency);
  expect_below("relative error of the first natural frequency", std::abs(0.5 / crossing / frequency - 1),
               0.05);
}

// Default settings but for the cap. Loads scale with E, so that beam theory gives the same tip at each
// stiffness.
TEST(Cantilever, FollowsYoungsModulusAndNotTheIterationCap) {
  const auto open = open_double();
  const int length = 10, n = 3;
  double tips[3];
  const double etas[] = {1e2, 1e4, 1e6};
  for (int k = 0; k < 3; ++k) {
    double tip[2];
    for (int doubled = 0; doubled < 2; ++doubled) {
      // eta = 7.2 E h^2 / (rho spacing^2) at the ratio of 1/4; measured below.
      const double young = etas[k] * 1000 * spacing * spacing * 3600 / 7.2;
      Stage stage = cantilever(length, n, young, 1. / 60);
      const SolverSettings defaults;
      stage.scene.solver.tolerance = defaults.tolerance;
      stage.scene.solver.iterations = defaults.iterations << doubled;
      // Gravity, the same for all: a tenth of a spacing at the softest.
      stage.scene.simulation.gravity = {0, -0.2, 0};
      const Points rest = stage.model.position;
      Simulation simulation(*open, stage.scene, stage.model);
      if (!doubled) report("eta", simulation.stiffness_number());
      const int steps = k == 0 ? 1000 : 120;
      for (int step = 0; step < steps; ++step) simulation.step();
      const auto rows = simulation.take_statistics();
      tip[doubled] = tip_deflection(stage, rest, simulation.positions());
      if (!doubled) report("iterations of the last step", rows.back().iterations);
    }
    tips[k] = tip[0];
    report("tip, spacings", tip[0]);
    expect_below("tip moved by twice the iterations, relative", std::abs(tip[1] / tip[0] - 1), 0.02);
  }
  expect_below("tip(1e2) E(1e2) against tip(1e4) E(1e4), relative", std::abs(tips[0] / tips[1] / 100 - 1),
               0.03);
  expect_below("tip(1e4) E(1e4) against tip(1e6) E(1e6), relative", std::abs(tips[1] / tips[2] / 100 - 1),
               0.03);
}

INSTANTIATE_TEST_SUITE_P(Physics, Bending, testing::ValuesIn(device_choices()), ChoiceName());

} // namespace
} // namespace pliant::test
