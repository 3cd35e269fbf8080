// Figures of Xu, He, Chen, Li and Wang, "Reformulating Hyperelastic Materials with Peridynamic Modeling"
// (2018), that need sheets, influences or horizons, from the scenes in examples/, sampled more coarsely.
#include "tests/sheets/sheets.h"

#include "engine/scene/mesh.h"

#include <filesystem>

namespace pliant::test {
namespace {

Scene example(const std::string& name, const std::vector<std::string>& overrides) {
  return read_scene(std::filesystem::path(PLIANT_SOURCE_DIR) / "examples" / (name + ".toml"), overrides);
}

Points run(Simulation& simulation, const Scene& scene, const std::function<void(const Points&)>& each = {}) {
  const auto steps = std::lround(scene.simulation.end / simulation.time_step());
  for (long k = 0; k < steps; ++k) {
    simulation.step();
    if (each) each(simulation.positions());
  }
  return simulation.positions();
}

double lowest(const Model& model, const Points& y, std::uint32_t body) {
  double least = 1e300;
  for (std::uint32_t i = model.bodies[body].first; i < model.bodies[body].first + model.bodies[body].count;
       ++i)
    least = std::min(least, y[i].y());
  return least;
}
double highest(const Model& model, const Points& y, std::uint32_t body) {
  double most = -1e300;
  for (std::uint32_t i = model.bodies[body].first; i < model.bodies[body].first + model.bodies[body].count;
       ++i)
    most = std::max(most, y[i].y());
  return most;
}

// Fig. 9. The rigidity goes with <r^2>, 1.4 and 5.1 squares of the spacing.
TEST(SheetFigure, AWiderHorizonResistsBendingMore) {
  const Scene scene = example("cloth-horizon", {"simulation.spacing=0.025", "simulation.end=1.5"});
  const Model model = assemble(scene);
  const auto open = open_double(2);
  Simulation simulation(*open, scene, model);
  const Points y = run(simulation, scene);
  const double short_ends = 0.6 - lowest(model, y, 0), long_ends = 0.6 - lowest(model, y, 1);
  report("ends of the cloth of 1.87 spacings hang by, m", short_ends);
  report("ends of the cloth of 3.1 spacings hang by, m", long_ends);
  expect_above("how much lower the more flexible one hangs", short_ends / long_ends, 1.15);
}

// Fig. 6, isotropic.
TEST(SheetFigure, ATrampolineThrowsTheBallUpAgain) {
  const Scene scene = example("trampoline", {"simulation.spacing=0.05", "simulation.end=0.9"});
  const Model model = assemble(scene);
  const auto open = open_double(2);
  Simulation simulation(*open, scene, model);
  double deepest = 1e300, rebound = -1e300;
  const Points y = run(simulation, scene, [&](const Points& now) {
    const double sheet = lowest(model, now, 0), ball = lowest(model, now, 1);
    deepest = std::min(deepest, sheet);
    if (sheet > deepest + 0.02) rebound = std::max(rebound, ball);
    EXPECT_TRUE(std::isfinite(ball));
  });
  report("the mat gives way by, m", 0.6 - deepest);
  report("the ball's lowest point rises to, m above the mat at rest", rebound - 0.6);
  expect_above("the mat gives way by, m", 0.6 - deepest, 0.05);
  expect_above("the ball leaves the mat by, m", rebound - 0.6, 0.05);
  for (const Held& held : model.held)
    EXPECT_LT((y[held.particle] - model.position[held.particle]).norm(), 1e-12);
}

// Fig. 8.
TEST(SheetFigure, BarsNarrowAsTheirRatiosSayWhateverTheWeights) {
  const Scene scene = example("poisson-bars", {"simulation.influence=increasing", "simulation.spacing=0.025",
                                               "simulation.time_step=0.1", "solver.tolerance=1e-5"});
  const Model model = assemble(scene);
  const auto open = open_double(2);
  Simulation simulation(*open, scene, model);
  const Points y = run(simulation, scene);
  for (const BodyModel& body : model.bodies) {
    const auto inside = [&](std::uint32_t i) { return std::abs(model.position[i].y() - 0.3) < 0.05; };
    Vector3 centre = Vector3::Zero(), shift = Vector3::Zero();
    double count = 0;
    for (std::uint32_t i = body.first; i < body.first + body.count; ++i)
      if (inside(i)) centre += model.position[i], shift += y[i] - model.position[i], count += 1;
    centre /= count, shift /= count;
    double along = 0, along2 = 0, across = 0, across2 = 0;
    for (std::uint32_t i = body.first; i < body.first + body.count; ++i) {
      if (!inside(i)) continue;
      const Vector3 x = model.position[i] - centre, u = y[i] - model.position[i] - shift;
      along += x.y() * u.y(), along2 += x.y() * x.y();
      across += x.x() * u.x() + x.z() * u.z(), across2 += x.x() * x.x() + x.z() * x.z();
    }
    expect_below(
        body.name + ": |ratio - typed|",
        std::abs(-across / across2 / (along / along2) - typed_material(scene, model, body.first).poisson),
        0.01);
  }
}

// Fig. 13: what weighs more stands less high.
TEST(SheetFigure, AShellSagsWithGravity) {
  const Scene scene = example("shell-gravity", {"simulation.spacing=0.05", "simulation.end=0.8"});
  try {
    find_mesh(scene.bodies[0].shape.mesh, scene.file.parent_path());
  } catch (const Error&) {
    GTEST_SKIP() << "bunny00.off is not on this machine";
  }
  const Model model = assemble(scene);
  const auto open = open_double(2);
  Simulation simulation(*open, scene, model);
  const Points y = run(simulation, scene);
  double before = 1e300;
  for (std::uint32_t b = 0; b < 4; ++b) {
    const double height = highest(model, y, b);
    report(model.bodies[b].name + ": height, m", height);
    EXPECT_LT(height, before) << model.bodies[b].name;
    EXPECT_GT(height, 0.05);
    before = height;
  }
}

// Fig. 10 and V10: no neighbourhood turns inside out, and the bar comes back.
TEST(SheetFigure, ABarTwistedByAFullTurnUntwists) {
  const Scene scene = example("twist", {"simulation.spacing=0.04", "simulation.end=6"});
  const Model model = assemble(scene);
  const auto open = open_double(2);
  Simulation simulation(*open, scene, model);
  double least = 1e300, strain = 0;
  int step = 0;
  const Points y = run(simulation, scene, [&](const Points& now) {
    if (++step % 20 != 0) return;
    strain = std::max(strain, rms_bond_strain(model, now));
    for (std::uint32_t i = 0; i < model.count(); ++i)
      least = std::min(least, determinant(deformation_gradient(model, now, i)));
  });
  report("largest root mean square strain of bonds", strain);
  expect_above("least det F", least, 0.1);
  expect_below("strain at the end, root mean square", rms_bond_strain(model, y), 1e-3);
}

} // namespace
} // namespace pliant::test
