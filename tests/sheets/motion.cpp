// Sheets and plane scenes in motion: forces are gradients, momentum stays, what is flat stays flat to the
// last bit, turning the scene turns the result, and both backends agree.
#include "engine/model/hierarchy.h"
#include "tests/sheets/sheets.h"

#include "tests/support/devices.h"

#include <Eigen/Geometry>

namespace pliant::test {
namespace {

/// Worst error of -f . d against the difference of the energy, as in tests/physics/gradients.cpp.
double gradient_error(Simulation& simulation, const Points& y, bool plane) {
  std::mt19937 random(7);
  const std::vector<Vector3> force = simulation.elastic_forces(y);
  double worst = 0;
  for (int trial = 0; trial < 12; ++trial) {
    std::vector<Vector3> d(y.size(), Vector3::Zero());
    if (trial < 6) {
      for (Vector3& v : d) v = random_vector(random);
    } else { // one particle alone: nothing averages out
      d[random() % d.size()] = random_vector(random);
    }
    if (plane)
      for (Vector3& v : d) v.z() = 0;
    const double s = 3e-6;
    const auto energy = [&](double t) { return simulation.elastic_energy(plus(y, t * s, d)); };
    const double slope = (8 * (energy(1) - energy(-1)) - (energy(2) - energy(-2))) / (12 * s);
    worst = std::max(worst, std::abs(slope + inner(force, d)) / std::sqrt(inner(force, force) * inner(d, d)));
  }
  return worst;
}

// Coarse elements of a sheet have its own lambda' = 2 mu nu / (1 - nu), not that of a solid, which has none
// at such a ratio.
TEST(SheetHierarchy, StiffensAsTheSheetDoes) {
  for (const double poisson : {0.3, 0.9}) {
    const Scene scene = sheet_scene("corotated", poisson).scene();
    const Hierarchy made = build_hierarchy(scene, assemble(scene));
    ASSERT_GE(made.stiffness.size(), 12u);
    for (std::size_t entry = 10; entry < made.stiffness.size();
         entry += 12) // lambda / mu of a pair of corners
      EXPECT_NEAR(made.stiffness[entry], 2 * poisson / (1 - poisson), 1e-9);
  }
}

// V4. In space a sheet is crumpled; in a plane scene it is also mirrored, which only a rotation about z
// undoes right.
TEST(FlatForces, AreTheGradientsOfTheEnergy) {
  const auto open = open_double();
  for (const bool plane : {false, true})
    for (const char* law : {"corotated", "ordinary"})
      for (const double noise : {0.005, 0.03})
        for (const double mirror : {1.0, -0.9}) {
          if (!plane && mirror < 0) continue;
          FlatScene made = plane ? plane_scene("strain", law) : sheet_scene(law);
          made.width = 0.9;
          const Scene scene = made.scene();
          const Model model = assemble(scene);
          Simulation simulation(*open, scene, model);
          std::mt19937 random(11);
          Points y;
          for (const Vector3& x : model.position) {
            Vector3 moved = x + noise * random_vector(random);
            moved.x() *= mirror;
            if (plane) moved.z() = 0;
            y.push_back(moved);
          }
          expect_below(fmt::format("{} {}, noise {}, mirrored {}: force against energy",
                                   plane ? "plane" : "sheet", law, noise, mirror < 0),
                       gradient_error(simulation, y, plane), 1e-7);
        }
}

/// A sheet that is stretched and waved within its plane, and moves in it.
Model disturbed(const Scene& scene) {
  Model model = assemble(scene);
  const Matrix3 axes = model.bodies[0].axes;
  const Points own = own_positions(model, model.position);
  for (std::size_t i = 0; i < model.count(); ++i) {
    const Vector3& x = own[i];
    model.position[i] += axes * Vector3(0.05 * std::sin(3 * x.y()), 0.04 * std::cos(2 * x.x()), 0);
    model.velocity[i] = axes * Vector3(0.2 * x.y(), 0.1, 0);
  }
  return model;
}

class Flat : public testing::TestWithParam<DeviceChoice> {};
INSTANTIATE_TEST_SUITE_P(Devices, Flat, testing::ValuesIn(device_choices()), ChoiceName());

TEST_P(Flat, StaysFlatToTheLastBit) {
  const auto open = open_alone(GetParam());
  for (const bool plane : {false, true})
    for (const char* method : {"chebyshev", "newton", "lbfgs"}) {
      FlatScene made = plane ? plane_scene("strain") : sheet_scene();
      made.width = 1.2;
      made.rest = fmt::format("method = \"{}\"\npreconditioner = \"diagonal\"\niterations = 60", method);
      const Scene scene = made.scene();
      const Model model = disturbed(scene);
      Simulation simulation(*open, scene, model);
      for (int k = 0; k < 4; ++k) simulation.step();
      double out = 0, moved = 0;
      const Points y = simulation.positions();
      for (std::size_t i = 0; i < y.size(); ++i) {
        out = std::max(out, std::abs(y[i].z()));
        moved = std::max(moved, (y[i] - model.position[i]).norm());
      }
      EXPECT_EQ(out, 0) << method << (plane ? ", plane" : ", sheet");
      EXPECT_GT(moved, 0.01);
    }
}

// A plane body that starts mirrored comes back by turning inside its plane's own rules, not by leaving it.
TEST_P(Flat, AMirroredCornerComesBackInThePlane) {
  FlatScene made = plane_scene("strain");
  made.width = 0.9;
  made.step = 0.02;
  made.rest = "iterations = 300";
  const Scene scene = made.scene();
  Model model = assemble(scene);
  const Points rest = model.position;
  for (Vector3& x : model.position)
    if (x.x() > 0.2) x.x() = 0.4 - x.x(); // folded over itself
  const auto open = open_alone(GetParam());
  Simulation simulation(*open, scene, model);
  for (int k = 0; k < 60; ++k) simulation.step();
  const Points y = simulation.positions();
  double strain = 0, out = 0;
  for (std::uint32_t i = 0; i < model.count(); ++i) {
    out = std::max(out, std::abs(y[i].z()));
    for (std::uint32_t b = model.bonds.begin[i]; b < model.bonds.begin[i + 1]; ++b) {
      const std::uint32_t j = model.bonds.neighbour[b];
      strain = std::max(
          strain, std::abs((y[j] - y[i]).norm() / (model.reference[j] - model.reference[i]).norm() - 1));
    }
  }
  EXPECT_EQ(out, 0);
  expect_below("largest strain left in a bond", strain, 0.02);
}

// Float holds positions of 1 m to 6e-8; a run of a few steps sums a few hundred such roundings of a spacing
// of 0.1 m, and the solver stops at 1e-6 of residuals that move particles by tenths of a spacing.
TEST_P(Flat, AgreesWithTheCpuInDouble) {
  for (const bool plane : {false, true})
    for (const char* method : {"chebyshev", "newton"}) {
      FlatScene made = plane ? plane_scene("stress") : sheet_scene();
      made.width = 1.2;
      made.rest = fmt::format("method = \"{}\"\npreconditioner = \"diagonal\"", method);
      const Scene scene = made.scene();
      Model model = disturbed(scene);
      if (!plane)
        for (Vector3& y : model.position) y.z() += 0.03 * std::sin(4 * y.x()); // bent out of its plane too
      const auto open = open_alone(GetParam());
      const auto reference = open_double();
      Simulation one(*open, scene, model), other(*reference, scene, model);
      for (int k = 0; k < 3; ++k) one.step(), other.step();
      expect_below(fmt::format("{}, {}: difference, spacings", plane ? "plane" : "sheet", method),
                   largest_difference(one.positions(), other.positions()) / 0.1, 2e-3);
    }
}

TEST(FlatMotion, ConservesMomentum) {
  FlatScene made = sheet_scene();
  made.width = 1.2;
  made.rest = "method = \"newton\"";
  const Scene scene = made.scene();
  Model model = disturbed(scene);
  for (std::size_t i = 0; i < model.count(); ++i)
    model.velocity[i] += Vector3(0, 0, 0.3 * std::sin(5 * model.position[i].x()));
  const auto open = open_double();
  Simulation simulation(*open, scene, model);
  const auto momentum = [&] {
    Vector3 sum = Vector3::Zero();
    const std::vector<Vector3> v = simulation.velocities();
    for (std::size_t i = 0; i < v.size(); ++i) sum += model.mass[i] * v[i];
    return sum;
  };
  double size = 0;
  for (std::size_t i = 0; i < model.count(); ++i) size += model.mass[i] * model.velocity[i].norm();
  const Vector3 before = momentum();
  for (int k = 0; k < 10; ++k) simulation.step();
  expect_below("change of momentum, of sum m |v|", (momentum() - before).norm() / size, 1e-12);
}

// V16. The tolerance of 1e-9 leaves errors of its own size times the motion.
TEST(FlatMotion, TurnsWithTheScene) {
  Points results[2];
  for (const bool turned : {false, true}) {
    FlatScene made = sheet_scene();
    made.width = 1.2;
    made.rest = "method = \"newton\"";
    if (turned) made.shape = ", at = [0.3, 1, -2], rotate = { axis = [1, 2, 3], degrees = 50 }";
    Scene scene = made.scene();
    scene.solver.tolerance = 1e-11;
    Model model = disturbed(scene);
    const Matrix3 axes = model.bodies[0].axes;
    for (std::size_t i = 0; i < model.count(); ++i)
      model.velocity[i] += axes * Vector3(0, 0, 0.3 * std::sin(5 * model.reference[i].x()));
    const auto open = open_double();
    Simulation simulation(*open, scene, model);
    for (int k = 0; k < 6; ++k) simulation.step();
    results[turned] = own_positions(model, simulation.positions());
  }
  expect_below("difference, m", largest_difference(results[0], results[1]), 1e-9);
}

// V19, catenary: a strip one metre long held at its ends, 0.8 m apart. The ordinary law's layers do not
// resist bending, and this one stretches by 1e-3 at most.
TEST(FlatMotion, AHungStripIsACatenary) {
  FlatScene made = sheet_scene("ordinary");
  made.width = 1.05, made.height = 0.25;
  Scene scene =
      parse_scene(made.text(), "flat.toml",
                  {"simulation.spacing=0.05", "materials.cloth.young=5e6", "simulation.gravity=[0, 0, -9.81]",
                   "simulation.time_step=0.05", "solver.tolerance=1e-4", "solver.iterations=4000"});
  Model model = assemble(scene);
  model.motions.push_back({});
  // Centres of the end columns are 1 m apart along the strip; they are brought to 0.8 m.
  const double length = 1, apart = 0.8;
  double c = 1, low = 0.05, high = 10;
  for (int k = 0; k < 200; ++k) { // bisection: 2 c sinh(a / 2c) falls with c
    c = (low + high) / 2;
    (2 * c * std::sinh(apart / (2 * c)) > length ? low : high) = c;
  }
  const double sag = c * (std::cosh(apart / (2 * c)) - 1);
  // Start on a shallow arc of the right ends, hanging: an arc length away from the middle by a parabola.
  for (std::uint32_t i = 0; i < model.count(); ++i) {
    const double s = model.position[i].x() / (length / 2);
    model.position[i].x() *= apart / length;
    model.position[i].z() = -0.9 * sag * (1 - s * s);
    if (std::abs(s) > 1 - 1e-6) model.held.push_back({i, 0});
  }
  const auto open = open_double(2);
  Simulation simulation(*open, scene, model);
  for (int k = 0; k < 60; ++k) simulation.step();
  const Points y = simulation.positions();
  double lowest = 0;
  for (const Vector3& p : y) lowest = std::min(lowest, p.z());
  report("sag of the catenary, m", sag);
  report("sag measured, m", -lowest);
  expect_below("sag against the catenary", std::abs(-lowest / sag - 1), 0.02);
}

} // namespace
} // namespace pliant::test
