// examples/coiling.toml: a thin rope of honey turns about its axis as it lands, where its viscosity lets it.
#include "tests/support/examples.h"
#include "tests/support/fluids.h"

#include <cmath>
#include <numbers>

namespace pliant::test {
namespace {

/// How the rope goes round, a little above the heap, from when it has landed to the end.
struct Winding {
  double turns = 0;  ///< all together, in one sense
  double radius = 0; ///< of its middle about the mean of it, in radii of the spout, rms
};
Winding wind(const char* form, double end) {
  const Scene scene = example_scene(
      "coiling", {std::string("fluid.viscosity_form=") + form, "simulation.end=" + std::to_string(end)});
  const Model model = assemble(scene);
  const auto device = open_alone({"openmp_float", "openmp", Precision::single_precision});
  Simulation simulation(*device, scene, model);
  std::vector<Vector3> middle;
  int k = 0;
  run_scene(simulation, scene, [&](const Points& at) {
    if (++k % 4 != 0 || k < 120) return;
    const std::size_t there = simulation.fluid()->flow()->emitted();
    Vector3 sum = Vector3::Zero();
    double count = 0;
    for (std::size_t i = 0; i < there; ++i)
      if (at[i].y() > 0.035 && at[i].y() < 0.045) sum += at[i], ++count;
    if (count > 0) middle.push_back(sum / count);
  });
  Vector3 centre = Vector3::Zero();
  for (const Vector3& p : middle) centre += p / double(middle.size());
  Winding found;
  double last = 0, squares = 0, angle = 0;
  for (std::size_t i = 0; i < middle.size(); ++i) {
    const Vector3 from = middle[i] - centre;
    squares += (from.x() * from.x() + from.z() * from.z()) / double(middle.size());
    const double now = std::atan2(from.z(), from.x());
    if (i > 0) angle += std::remainder(now - last, 2 * std::numbers::pi);
    last = now;
  }
  found.turns = std::abs(angle) / (2 * std::numbers::pi);
  found.radius = std::sqrt(squares) / *scene.emitters[0].disc;
  return found;
}

TEST(FluidCoiling, RopesCoilWhereForcesAreCentral) {
  const Winding central = wind("central", 0.9);
  expect_above("turns", central.turns, 1.5);
  expect_above("radius of the turns, of the spout's", central.radius, 0.7);
  // Which has forces on what turns as a whole too.
  expect_below("the same along differences of velocities", wind("laplacian", 0.6).radius, 0.1);
}

} // namespace
} // namespace pliant::test
