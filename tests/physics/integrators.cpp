// The damping and phase that the integrators have by theory: free vibration in one natural mode, free spin,
// and order in the time step.
#include "tests/support/modes.h"

#include <complex>

namespace pliant::test {
namespace {

using Complex = std::complex<double>;
constexpr double spacing = 0.1;

Stage beam() {
  Stage stage(lattice(8, 3, 2, spacing), spacing, material_of("corotated", 1e6, 0.3), 0.01);
  const double first = stage.model.position.front().x();
  stage.hold([&](const Vector3& x) { return x.x() < first + 1.5 * spacing; });
  stage.scene.solver.tolerance = 1e-10;
  return stage;
}

/// The amplitude of a mode as a complex number that turns by exp(-i omega t) in exact motion.
Complex amplitude(Simulation& simulation, const Points& rest, const Mode& mode) {
  const double square = inner(mode.shape, mode.shape);
  return {inner(mode.shape, plus(simulation.positions(), -1, rest)) / square,
          inner(mode.shape, simulation.velocities()) / square / mode.omega};
}

/// How far the solver's floor lets a step's correction of this mode be off, relative: the floor over the
/// residual that the mode's own elastic force has in the same norm, at the amplitude given.
double floor_share(Simulation& simulation, const Stage& stage, const Mode& mode, double floor, double size) {
  const double diagonal =
      simulation.stiffness_number() * stage.model.mass[0] / std::pow(simulation.time_step(), 2);
  return floor / (stage.model.mass[0] * mode.omega * mode.omega * size *
                  std::sqrt(inner(mode.shape, mode.shape) / diagonal));
}

class Vibration : public OnEachDevice {};

// Float: a correction of omega^2 h^2 a decays the amplitude by half of that, so a share s of it left undone
// is an error of 2 s of the rate; the share at the smallest amplitude, that of the end, is the worst.
TEST_P(Vibration, DecaysAndTurnsAsImplicitEulerDoes) {
  const Mode mode = lowest_mode(beam());
  const double size = limit(1e-5, 1e-2);
  const int steps = 4;
  const auto open = device();
  for (const double turn : {0.1, 0.3, 1.0}) {
    Stage stage = beam();
    stage.time_step(turn / mode.omega);
    const Points rest = stage.model.position;
    stage.model.position = plus(rest, size, mode.shape);
    Simulation simulation(*open, stage.scene, stage.model);
    const Complex start = amplitude(simulation, rest, mode);
    for (int k = 0; k < steps; ++k) simulation.step();
    const Complex ratio = amplitude(simulation, rest, mode) / start;
    const double floor = simulation.take_statistics().back().floor;
    const double decay = -std::log(std::abs(ratio)) / steps, expected = std::log(1 + turn * turn) / 2;
    double phase = -std::arg(ratio);
    if (phase < 0) phase += 2 * std::acos(-1.0);
    const double allowed = 0.01 + 2 * floor_share(simulation, stage, mode, floor, size * std::abs(ratio));
    const std::string name = "omega h = " + std::to_string(turn).substr(0, 3);
    expect_below(name + ": decay rate, relative error", std::abs(decay / expected - 1), limit(0.01, allowed));
    expect_below(name + ": phase rate, relative error", std::abs(phase / steps / std::atan(turn) - 1),
                 limit(0.01, allowed));
  }
}

struct Period {
  Complex end;      ///< amplitude after a period, of that at the start
  double share = 0; ///< that the floor leaves undone
};

Period one_period(Device& device, const Mode& mode, int steps, const char* integrator, double size) {
  Stage stage = beam();
  stage.scene.solver.integrator = integrator;
  stage.time_step(2 * std::acos(-1.0) / mode.omega / steps);
  const Points rest = stage.model.position;
  stage.model.position = plus(rest, size, mode.shape);
  Simulation simulation(device, stage.scene, stage.model);
  const Complex start = amplitude(simulation, rest, mode);
  for (int k = 0; k < steps; ++k) simulation.step();
  const double floor = simulation.take_statistics().back().floor;
  return {amplitude(simulation, rest, mode) / start, floor_share(simulation, stage, mode, floor, size)};
}

TEST(Order, ConvergesWithTheOrderOfItsIntegrator) {
  const Mode mode = lowest_mode(beam());
  const auto open = open_double();
  for (const auto& [name, order, coarse] : {std::tuple{"implicit-euler", 1.0, 200}, {"bdf2", 2.0, 40}}) {
    double error[3];
    for (int level = 0; level < 3; ++level) {
      error[level] = std::abs(one_period(*open, mode, coarse << level, name, 1e-5).end - 1.0);
      report(std::string(name) + ": error over a period, " + std::to_string(coarse << level) + " steps",
             error[level]);
    }
    for (int level = 0; level < 2; ++level)
      expect_below(std::string(name) + ": |order - " + std::to_string(order).substr(0, 1) + "|",
                   std::abs(std::log2(error[level] / error[level + 1]) - order), 0.2);
  }
}

// Each step leaves a share of its correction of omega^2 h^2 undone, in the worst case always with the same
// sign.
TEST_P(Vibration, APeriodIsThatOfDouble) {
  const Mode mode = lowest_mode(beam());
  const auto open = device(), reference = open_double();
  const double size = 1e-2, turn = 2 * std::acos(-1.0) / 30;
  for (const char* name : {"implicit-euler", "bdf2"}) {
    const Period own = one_period(*open, mode, 30, name, size),
                 exact = one_period(*reference, mode, 30, name, size);
    expect_below(std::string(name) + ": distance from double after a period, of the amplitude",
                 std::abs(own.end - exact.end), limit(1e-12, 30 * turn * own.share));
  }
}

class Spin : public OnEachDevice {};

double spin_left(Device& device, const char* integrator, int rate, double tolerance) {
  const double omega = 2 * std::acos(-1.0);
  Stage stage(lattice(5, 5, 5, spacing), spacing, material_of("corotated", 1e6, 0.3), 1.0 / rate);
  stage.scene.solver.integrator = integrator;
  stage.scene.solver.tolerance = tolerance;
  Vector3 centre = Vector3::Zero();
  for (const Vector3& x : stage.model.position) centre += x / static_cast<double>(stage.model.count());
  const Vector3 axis = Vector3(1, 2, 3).normalized();
  for (std::size_t i = 0; i < stage.model.count(); ++i)
    stage.model.velocity[i] = omega * axis.cross(stage.model.position[i] - centre);
  Simulation simulation(device, stage.scene, stage.model);
  const auto momentum = [&] {
    const Points y = simulation.positions(), v = simulation.velocities();
    double sum = 0;
    for (std::size_t i = 0; i < y.size(); ++i) sum += axis.dot((y[i] - centre).cross(v[i]));
    return sum;
  };
  const double start = momentum();
  for (int k = 0; k < rate; ++k) simulation.step();
  return momentum() / start;
}

TEST_P(Spin, SlowsAsTheoryPredicts) {
  const double omega = 2 * std::acos(-1.0);
  const auto open = device();
  const double expected = 1 / std::sqrt(1 + 2 * omega * omega / 60),
               euler = spin_left(*open, "implicit-euler", 60, limit(1e-6, 1e-4));
  report("implicit Euler, 60 Hz, L / L0 after 1 s", euler);
  // The formula is the limit of small angles a step; the rounding of float is far below in either case.
  expect_below("implicit Euler: L / L0 against (1 + 2 h w^2 t)^-1/2", std::abs(euler / expected - 1), 0.01);
  expect_above("BDF2, 60 Hz: L / L0 after 1 s", spin_left(*open, "bdf2", 60, limit(1e-6, 1e-4)), 0.98);
}

INSTANTIATE_TEST_SUITE_P(Physics, Vibration, testing::ValuesIn(device_choices()), ChoiceName());
INSTANTIATE_TEST_SUITE_P(Physics, Spin, testing::ValuesIn(device_choices()), ChoiceName());

} // namespace
} // namespace pliant::test
