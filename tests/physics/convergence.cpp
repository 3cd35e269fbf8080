// Order of convergence in the spacing, and in the time step for a bar that bends far.
#include "tests/support/modes.h"

namespace pliant::test {
namespace {

constexpr double young = 1e5, poisson = 0.3, wave = 2, amplitude = 1e-4;

/// A smooth field; not a harmonic one, on which isotropic lattices are of higher order.
Vector3 exact_displacement(const Vector3& x) {
  return amplitude * Vector3(std::sin(wave * x.x()) * std::sin(wave * x.y()), 0, 0);
}

/// The force density that Navier's equations ask for it, N/m3.
Vector3 force_density(const Vector3& x) {
  const double mu = young / (2 * (1 + poisson)), lame = young * poisson / ((1 + poisson) * (1 - 2 * poisson));
  const double s = std::sin(wave * x.x()) * std::sin(wave * x.y()),
               c = std::cos(wave * x.x()) * std::cos(wave * x.y());
  return amplitude * wave * wave * Vector3((3 * mu + lame) * s, -(mu + lame) * c, 0);
}

/// A unit cube of n^3 particles, two more layers around it held in the exact displacement: the largest error
/// inside, of the largest displacement.
double spatial_error(Device& device, const char* law, int n) {
  const double spacing = 1.0 / n;
  Stage stage(lattice(n + 3, n + 3, n + 3, spacing), spacing, material_of(law, young, poisson), 1. / 60);
  const Vector3 low = stage.model.position[0]; // the lattice is lexicographic: its lowest corner
  const auto local = [&](const Vector3& x) -> Vector3 { return x - low - Vector3::Constant(spacing); };
  stage.hold([&](const Vector3& x) {
    const Vector3 p = local(x);
    return (p.array() < spacing / 2).any() || (p.array() > 1 - spacing / 2).any();
  });
  const Points rest = stage.model.position;
  const std::vector<bool> free = stage.free_particles();
  for (std::uint32_t i = 0; i < rest.size(); ++i) {
    const Vector3 p = local(rest[i]);
    stage.model.position[i] += exact_displacement(p);
    if (free[i])
      stage.model.loads.push_back({.particle = i, .force = stage.model.volume[i] * force_density(p)});
  }
  Simulation simulation(device, stage.scene, stage.model);
  const Points y = static_solution(simulation, stage, 2);
  double error = 0, size = 0;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    if (!free[i]) continue;
    const Vector3 u = exact_displacement(local(rest[i]));
    error = std::max(error, (y[i] - rest[i] - u).norm()), size = std::max(size, u.norm());
  }
  return error / size;
}

// Double only: the errors, 1e-5 of a displacement of 1e-4 of the cube, are below the rounding of float.
TEST(Convergence, IsOfSecondOrderInTheSpacing) {
  const auto open = open_double();
  for (const char* law : {"corotated", "ordinary"}) {
    const int sizes[] = {6, 9, 13};
    double error[3];
    for (int k = 0; k < 3; ++k) {
      error[k] = spatial_error(*open, law, sizes[k]);
      report(std::string(law) + ": error with " + std::to_string(sizes[k]) + " spacings a side", error[k]);
    }
    for (int k = 0; k < 2; ++k) {
      const double slope =
          std::log(error[k] / error[k + 1]) / std::log(static_cast<double>(sizes[k + 1]) / sizes[k]);
      expect_below(std::string(law) + ": |slope - 2|", std::abs(slope - 2), 0.2);
    }
  }
}

// The bar stretches where it bends: the axial modes that this excites are some fifty times as fast as the
// lowest, so the second order shows only at steps short for them.
TEST(Convergence, InTheTimeStepWhereTheBarBendsFar) {
  const double spacing = 0.1;
  const auto open = open_double();
  Stage stage(lattice(8, 3, 2, spacing), spacing, material_of("corotated", 1e6, 0.3), 0.01);
  const double first = stage.model.position.front().x();
  stage.hold([&](const Vector3& x) { return x.x() < first + 1.5 * spacing; });
  stage.scene.solver.tolerance = 1e-10;
  const Mode mode = lowest_mode(stage);
  const double duration = 1.2 / mode.omega;
  const std::vector<Vector3> still = stage.model.velocity;
  for (const auto& [name, order, coarse] : {std::tuple{"implicit-euler", 1.0, 40}, {"bdf2", 2.0, 200}}) {
    stage.scene.solver.integrator = name;
    stage.model.velocity =
        plus(still, 0.3 * mode.omega, mode.shape); // 0.3 of 0.7 m: a slope of more than 20 degrees
    Points end[4];
    for (int level = 0; level < 4; ++level) {
      stage.time_step(duration / (coarse << level));
      Simulation simulation(*open, stage.scene, stage.model);
      for (int k = 0; k < coarse << level; ++k) simulation.step();
      end[level] = simulation.positions();
    }
    for (int level = 0; level < 2; ++level) {
      const double one = largest_difference(end[level], end[level + 1]),
                   two = largest_difference(end[level + 1], end[level + 2]);
      report(std::string(name) + ": difference on halving the step, m", one);
      expect_below(std::string(name) + ": |order - " + std::to_string(order).substr(0, 1) + "|",
                   std::abs(std::log2(one / two) - order), 0.2);
    }
  }
}

} // namespace
} // namespace pliant::test
