// Figures of Xu, He, Chen, Li and Wang, "Reformulating Hyperelastic Materials with Peridynamic Modeling"
// (2018), in which bodies fall on sheets with directions, from the scenes in examples/, sampled more
// coarsely.
#include "tests/sheets/sheets.h"
#include "tests/support/examples.h"

#include <complex>
#include <numbers>

namespace pliant::test {
namespace {

double lowest(const Model& model, const Points& y, std::size_t body) {
  double least = 1e300;
  for (std::uint32_t i = model.bodies[body].first; i < model.bodies[body].first + model.bodies[body].count;
       ++i)
    least = std::min(least, y[i].y());
  return least;
}

/// A field over a round sheet as a function of the angle: its mean and its part of period 180 degrees, over a
/// ring of radii 0.2 to 0.4 m.
struct Pattern {
  double angle = 0; ///< degrees from x towards z, where the field is largest
  double ratio = 0; ///< the field there over that at right angles
};
template <class Field>
Pattern pattern(const Scene& scene, const Model& model, std::size_t body, const Field& field) {
  const BodyModel& sheet = model.bodies[body];
  double mean = 0;
  std::complex<double> second = 0;
  for (std::uint32_t i = sheet.first; i < sheet.first + sheet.count; ++i) {
    const Vector3 x = model.position[i] - scene.bodies[body].shape.at;
    const double radius = std::hypot(x.x(), x.z());
    if (radius < 0.2 || radius > 0.4) continue;
    const std::complex<double> direction(x.x() / radius, x.z() / radius);
    mean += field(i), second += 2 * field(i) * std::conj(direction * direction);
  }
  return {-std::arg(second) / 2 * 180 / std::numbers::pi,
          (mean + std::abs(second)) / (mean - std::abs(second))};
}

// Fig. 6 (b), (c). Threads along the strong direction carry the ball: the strain runs in a band along them,
// and the hollow is longer there. Both turn with the material. The lattice and the rim are symmetric about x
// and about the diagonal, so that angles are exact, and by quarter turns, so that without directions both
// ratios would be 1.
TEST(SheetFigure, ATrampolinesPatternTurnsWithItsDirections) {
  const Scene scene = example_scene(
      "trampoline-anisotropic", {"simulation.spacing=0.05", "simulation.end=1", "simulation.time_step=1/60"});
  const Model model = assemble(scene);
  const auto open = open_double();
  Simulation simulation(*open, scene, model);
  double depth = 0;
  Points y; // at the deepest
  run_scene(simulation, scene, [&](const Points& now) {
    const double deep = 0.6 - lowest(model, now, 0);
    if (deep > depth) depth = deep, y = now;
  });
  expect_above("the left sheet gives way by, m", depth, 0.05);
  for (std::size_t body = 0; body < 2; ++body) {
    const double strong = body == 0 ? 0 : 45;
    const std::string name = model.bodies[body].name + ": ";
    const Pattern strain = pattern(scene, model, body, [&](std::uint32_t i) {
      double sum = 0;
      for (std::uint32_t b = model.bonds.begin[i]; b < model.bonds.begin[i + 1]; ++b) {
        const std::uint32_t j = model.bonds.neighbour[b];
        sum += model.bonds.weight[b] *
               std::pow((y[j] - y[i]).norm() / (model.reference[j] - model.reference[i]).norm() - 1, 2);
      }
      return sum;
    });
    const Pattern hollow =
        pattern(scene, model, body, [&](std::uint32_t i) { return model.position[i].y() - y[i].y(); });
    expect_below(name + "band of strain off the strong direction, degrees",
                 std::abs(std::remainder(strain.angle - strong, 180)), 0.1);
    expect_below(name + "hollow off the strong direction, degrees",
                 std::abs(std::remainder(hollow.angle - strong, 180)), 0.1);
    expect_above(name + "mean square strain along over across", strain.ratio, 1.2);
    expect_above(name + "depth along over across", hollow.ratio, 1.05);
  }
}

// Fig. 11. All end at rest above the cloth, the right side out.
TEST(SheetFigure, FiveBodiesComeToRestOnAClothTheyDoNotPass) {
  const Scene scene = example_scene(
      "five-materials", {"simulation.spacing=0.04", "simulation.time_step=1/120", "allow=[\"sparse\"]"});
  if (!missing_mesh(scene).empty()) GTEST_SKIP() << missing_mesh(scene) << " is not on this machine";
  const Model model = assemble(scene);
  const auto open = open_alone({"openmp_float", "openmp", Precision::single_precision});
  Simulation simulation(*open, scene, model);
  std::size_t steps = 0, capped = 0;
  const Points y = run_scene(simulation, scene, [&](const Points&) {
    for (const StepStatistics& row : simulation.take_statistics())
      ++steps, capped += row.reason == StopReason::cap;
  });
  EXPECT_EQ(steps, 480);
  expect_below("share of steps that ended with their iterations", double(capped) / double(steps), 0.01);
  const std::vector<Vector3> velocity = simulation.velocities();
  const BodyModel& cloth = model.bodies[0];
  double depth = 0;
  for (std::uint32_t i = 0; i < cloth.count; ++i) depth = std::max(depth, 0.8 - y[i].y());
  report("the cloth gives way by, m", depth);
  for (std::size_t b = 1; b < model.bodies.size(); ++b) {
    const BodyModel& body = model.bodies[b];
    double under = 0, fast = 0, square = 0, full = 0, upright = 0;
    for (std::uint32_t i = body.first; i < body.first + body.count; ++i) {
      bool carried = false; // some of the cloth lies beneath: its holes are 1.3 spacings wide, folded or not
      for (std::uint32_t c = 0; c < cloth.count; ++c)
        carried |=
            std::hypot(y[c].x() - y[i].x(), y[c].z() - y[i].z()) < 1.5 * model.spacing && y[c].y() < y[i].y();
      under += !carried;
      fast = std::max(fast, velocity[i].norm());
      square += velocity[i].squaredNorm() / body.count;
      if (model.bonds.begin[i + 1] - model.bonds.begin[i] < 17) continue; // of an edge, a claw, an ear
      full += 1;
      upright += determinant(deformation_gradient(model, y, i) * body.axes.transpose()) > 0;
    }
    EXPECT_EQ(under, 0) << body.name;
    // Which way they roll depends on rounding, and a limb may swing a little longer than its body.
    expect_below(body.name + ": root mean square of its speeds at the end, m/s", std::sqrt(square), 0.1);
    expect_below(body.name + ": fastest particle at the end, m/s", fast, 0.2);
    expect_above(body.name + ": share with det F > 0", upright / full, 1);
  }
}

} // namespace
} // namespace pliant::test
