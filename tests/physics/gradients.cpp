// Forces are the negative gradients of the energies (central differences), and what is known of the
// projective law, which has none. Double precision: a difference of float energies says nothing at these
// limits.
#include "tests/support/bodies.h"

#include <Eigen/Dense>

namespace pliant::test {
namespace {

constexpr double spacing = 0.1;

/// Worst error of -f . d against the difference of the energy along random directions, relative to |f| |d|.
double gradient_error(Simulation& simulation, const Points& y, unsigned seed) {
  std::mt19937 random(seed);
  const std::vector<Vector3> force = simulation.elastic_forces(y);
  double worst = 0;
  for (int trial = 0; trial < 12; ++trial) {
    std::vector<Vector3> d(y.size(), Vector3::Zero());
    if (trial < 6) {
      for (Vector3& v : d) v = random_vector(random);
    } else { // one particle alone: nothing averages out
      d[random() % d.size()] = random_vector(random);
    }
    const double s = 3e-5 * spacing;
    // Fourth order, so that neither the truncation nor the rounding of the energies comes near the limit.
    const auto energy = [&](double t) { return simulation.elastic_energy(plus(y, t * s, d)); };
    const double slope = (8 * (energy(1) - energy(-1)) - (energy(2) - energy(-2))) / (12 * s);
    const double size = std::sqrt(inner(force, force) * inner(d, d));
    worst = std::max(worst, std::abs(slope + inner(force, d)) / size);
  }
  return worst;
}

struct State {
  const char* name;
  Matrix3 affine;
  double noise; // spacings
};

std::vector<State> states() {
  const Matrix3 one = Matrix3::Identity();
  Matrix3 sheared = one, flat = one, line = one, mirrored = one;
  sheared << 1.2, 0.3, 0, -0.1, 0.8, 0.2, 0, 0.1, 1.1;
  flat(1, 1) = 0;
  line(1, 1) = line(2, 2) = 0.02;
  mirrored(0, 0) = -0.9;
  mirrored(1, 1) = 1.1;
  return {{"near rest", one, 0.05},   {"sheared, random", sheared, 0.3}, {"random", one, 1.0},
          {"flattened", flat, 0.1},   {"exactly flat", flat, 0},         {"nearly a line", line, 0.1},
          {"inverted", mirrored, 0.1}};
}

Points deformed(const Points& rest, const State& state, unsigned seed) {
  std::mt19937 random(seed);
  Points y;
  for (const Vector3& x : rest) y.push_back(state.affine * x + state.noise * spacing * random_vector(random));
  return y;
}

TEST(Gradients, CorotatedAndNeoHookeanForcesAreTheGradientInEveryState) {
  const auto device = open_double();
  for (const char* law : {"corotated", "neo-hookean"})
    for (const double poisson : {0.0, 0.3, 0.45}) {
      Stage stage(lattice(6, 5, 4, spacing), spacing, material_of(law, 1e5, poisson), 1. / 60);
      Simulation simulation(*device, stage.scene, stage.model);
      const Points rest = simulation.positions();
      for (const State& state : states())
        expect_below(law + (", " + std::to_string(poisson).substr(0, 4)) + ", " + state.name,
                     gradient_error(simulation, deformed(rest, state, 11), 5), 1e-7);
    }
}

TEST(Gradients, OrdinaryForceIsTheGradient) {
  const auto device = open_double();
  for (const double poisson : {0.0, 0.25, 0.45}) {
    Stage stage(lattice(6, 5, 4, spacing), spacing, material_of("ordinary", 1e5, poisson), 1. / 60);
    Simulation simulation(*device, stage.scene, stage.model);
    const Points rest = simulation.positions();
    for (const State& state : states()) {
      if (std::string(state.name) == "exactly flat") continue; // bonds of no length have no direction
      expect_below(std::string("ordinary, ") + std::to_string(poisson).substr(0, 4) + ", " + state.name,
                   gradient_error(simulation, deformed(rest, state, 12), 6), 1e-7);
    }
  }
}

TEST(Gradients, ProjectiveForceIsTheGradientOfItsBondTerm) {
  const auto device = open_double();
  Material material = material_of("projective", 1e5, 0.25);
  material.split = 0; // bonds only: the other term's target is taken as fixed, so it has no gradient
  Stage stage(lattice(6, 5, 4, spacing), spacing, material, 1. / 60);
  Simulation simulation(*device, stage.scene, stage.model);
  const Points rest = simulation.positions();
  for (const State& state : states()) {
    if (std::string(state.name) == "exactly flat") continue;
    expect_below(std::string("projective, split 0, ") + state.name,
                 gradient_error(simulation, deformed(rest, state, 13), 7), 1e-7);
  }
}

/// |K - K^T| / |K| of the operator linearised at rest.
double asymmetry(Simulation& simulation, const Stage& stage) {
  const std::vector<bool> free = stage.free_particles();
  const Points rest = simulation.positions();
  const auto n = static_cast<Eigen::Index>(3 * rest.size());
  Eigen::MatrixXd k(n, n);
  for (Eigen::Index column = 0; column < n; ++column) {
    std::vector<Vector3> v(rest.size(), Vector3::Zero());
    v[static_cast<std::size_t>(column / 3)][column % 3] = 1;
    const std::vector<Vector3> f = stiffness_times(simulation, rest, v, free, 1e-5 * spacing);
    for (Eigen::Index row = 0; row < n; ++row) k(row, column) = f[static_cast<std::size_t>(row / 3)][row % 3];
  }
  return (k - k.transpose()).norm() / k.norm();
}

TEST(Gradients, TheProjectiveLawIsNotAGradient) {
  const auto device = open_double();
  for (const double split : {0.5, 1.0}) {
    Material material = material_of("projective", 1e5, 0.25);
    material.split = split;
    Stage stage(lattice(5, 5, 5, spacing), spacing, material, 1. / 60);
    Simulation simulation(*device, stage.scene, stage.model);
    const double size = asymmetry(simulation, stage);
    expect_above("projective, split " + std::to_string(split).substr(0, 3) + ": |K - K^T| / |K|", size, 0.01);
    EXPECT_LE(size, 0.15) << "about 5 % is known of this law";
  }
  for (const char* law : {"corotated", "ordinary"}) {
    Stage stage(lattice(5, 5, 5, spacing), spacing, material_of(law, 1e5, 0.3), 1. / 60);
    Simulation simulation(*device, stage.scene, stage.model);
    // Differences over 1e-5 of a spacing lose five of sixteen digits.
    expect_below(std::string(law) + ": |K - K^T| / |K|", asymmetry(simulation, stage), 1e-9);
  }
}

class Balance : public OnEachDevice {};

// Float: each bond's force is rounded once at either end, and each particle's sum at its own size.
TEST_P(Balance, ForcesSumToZeroAndTorquesToo) {
  const auto open = device();
  for (const char* law : {"corotated", "ordinary", "projective", "neo-hookean"}) {
    Stage stage(lattice(6, 5, 4, spacing), spacing, material_of(law, 1e5, 0.3), 1. / 60);
    Simulation simulation(*open, stage.scene, stage.model);
    const Points y = deformed(simulation.positions(), {"", Matrix3::Identity(), 0.3}, 3);
    const std::vector<Vector3> force = simulation.elastic_forces(y);
    Vector3 sum = Vector3::Zero(), torque = Vector3::Zero();
    double size = 0, moment = 0;
    for (std::size_t i = 0; i < y.size(); ++i) {
      sum += force[i], size += force[i].norm();
      torque += y[i].cross(force[i]), moment += y[i].norm() * force[i].norm();
    }
    expect_below(std::string(law) + ": sum of forces, of the sum of sizes", sum.norm() / size,
                 limit(1e-13, 1e-6));
    if (std::string(law) == "projective")
      report("projective: torque, of the sum of sizes (known: not zero)", torque.norm() / moment);
    else
      expect_below(std::string(law) + ": torque, of the sum of sizes", torque.norm() / moment,
                   limit(1e-12, 2e-6));
  }
}

INSTANTIATE_TEST_SUITE_P(Physics, Balance, testing::ValuesIn(device_choices()), ChoiceName());

} // namespace
} // namespace pliant::test
