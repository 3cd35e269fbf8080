// What a free body keeps: momentum after an early stop, free fall to the last bit or so, rest.
#include "tests/support/bodies.h"

namespace pliant::test {
namespace {

constexpr double spacing = 0.1;

Stage strained(const char* law) {
  Stage stage(lattice(6, 5, 4, spacing), spacing, material_of(law, 1e5, 0.3), 1. / 60);
  std::mt19937 random(21);
  for (std::size_t i = 0; i < stage.model.count(); ++i) {
    stage.model.position[i] += 0.2 * spacing * random_vector(random);
    stage.model.velocity[i] = random_vector(random) + Vector3(1, 0, 2);
  }
  stage.iterations(16); // far from converged: that is the point
  return stage;
}

class Momentum : public OnEachDevice {};

// Float: velocities are displacements over h, each rounded to 6e-8 of itself, as are the sums of 120 terms:
// 1e-6 is some ten times what that gives.
TEST_P(Momentum, IsKeptAfterAnEarlyStop) {
  const auto open = device();
  for (const char* law : {"corotated", "ordinary", "projective"}) {
    Stage stage = strained(law);
    Simulation simulation(*open, stage.scene, stage.model);
    double linear = 0, angular = 0;
    for (int k = 0; k < 10; ++k) {
      const std::vector<Vector3> before = simulation.velocities();
      simulation.step();
      const std::vector<Vector3> after = simulation.velocities(), y = simulation.positions();
      Vector3 change = Vector3::Zero(), turn = Vector3::Zero(), centre = Vector3::Zero();
      double speed = 0, arm = 0;
      for (const Vector3& x : y) centre += x / static_cast<double>(y.size());
      for (std::size_t i = 0; i < y.size(); ++i) {
        change += after[i] - before[i];
        turn += (y[i] - centre).cross(after[i] - before[i]); // sum m y x (y - y*) / h
        speed += before[i].norm();
        arm += (y[i] - centre).norm() * before[i].norm();
      }
      linear = std::max(linear, change.norm() / speed);
      angular = std::max(angular, turn.norm() / arm);
    }
    expect_below(std::string(law) + ": change of momentum a step, of M v", linear, limit(1e-10, 1e-6));
    if (std::string(law) == "projective")
      report("projective: angular residual a step, of M v r (its law has torque)", angular);
    else
      expect_below(std::string(law) + ": angular residual a step, of M v r", angular, limit(1e-10, 2e-6));
  }
}

TEST_P(Momentum, LeaksWithoutTheProjection) {
  Stage stage = strained("corotated");
  stage.scene.solver.restore_momentum = false;
  const auto open = device();
  Simulation simulation(*open, stage.scene, stage.model);
  const std::vector<Vector3> before = simulation.velocities();
  simulation.step();
  const std::vector<Vector3> after = simulation.velocities();
  Vector3 change = Vector3::Zero();
  double speed = 0;
  for (std::size_t i = 0; i < before.size(); ++i) change += after[i] - before[i], speed += before[i].norm();
  expect_above("without it: change of momentum a step, of M v", change.norm() / speed, 1e-6);
}

class Basics : public OnEachDevice {};

// After n steps of implicit Euler: -h^2 g n (n + 1) / 2. Float: a sum of n displacements, each rounded to
// 6e-8 of a position below 3 m after growing velocities rounded n times to 6e-8 of up to 10 m/s times h n.
TEST_P(Basics, FreeFallIsExact) {
  const auto open = device();
  const double h = 1. / 60, g = 9.81;
  const int steps = 45;
  for (const bool isolated : {false, true}) {
    Points points = lattice(3, 3, 3, isolated ? 3 * spacing : spacing);
    Stage stage(points, spacing, material_of("corotated", 1e5, 0.3), h);
    stage.scene.simulation.gravity = {0, -g, 0};
    const Points rest = stage.model.position;
    EXPECT_EQ(stage.model.bonds.count() == 0, isolated);
    Simulation simulation(*open, stage.scene, stage.model);
    for (int k = 0; k < steps; ++k) simulation.step();
    const Vector3 fall{0, -h * h * g * steps * (steps + 1) / 2, 0};
    Points expected;
    for (const Vector3& x : rest) expected.push_back(x + fall);
    expect_below(isolated ? "isolated particles: error of the fall, m" : "a body: error of the fall, m",
                 largest_difference(simulation.positions(), expected), limit(1e-12, 2e-5));
  }
}

TEST_P(Basics, BodyAtRestStaysAtRest) {
  const auto open = device();
  for (const char* law : {"corotated", "ordinary", "projective"}) {
    Stage stage(lattice(5, 4, 3, spacing), spacing, material_of(law, 1e7, 0.3), 1. / 30);
    const Points rest = stage.model.position;
    Simulation simulation(*open, stage.scene, stage.model);
    const Points start = simulation.positions();
    for (int k = 0; k < 50; ++k) simulation.step();
    // Float: the solver stops at its floor, a rounding of forces of size K spacing, so that a particle may
    // move by 1e-7 of a spacing a step; positions of a few spacings are multiples of 2e-8 m.
    expect_below(std::string(law) + ": drift after 50 steps, spacings",
                 largest_difference(simulation.positions(), start) / spacing, limit(1e-14, 1e-6));
    EXPECT_LE(largest_difference(start, rest), is_double() ? 1e-15 : 1e-7);
  }
}

INSTANTIATE_TEST_SUITE_P(Physics, Momentum, testing::ValuesIn(device_choices()), ChoiceName());
INSTANTIATE_TEST_SUITE_P(Physics, Basics, testing::ValuesIn(device_choices()), ChoiceName());

} // namespace
} // namespace pliant::test
