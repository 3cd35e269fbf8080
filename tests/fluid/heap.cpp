// Honey that spreads on a plate to which it sticks: every step is solved, though in each of its iterations
// some particles of the layer at the plate come to touch it and others cease to.
#include "tests/scene/parse.h"
#include "tests/support/fluids.h"

namespace pliant::test {
namespace {

TEST(FluidHeap, EveryStepConverges) {
  const Scene scene = parsed("[simulation]\nspacing = 0.005\ntime_step = \"1/150\"\n"
                             "[materials.honey]\nmodel = \"viscoelastic\"\ndensity = 1400\nyoung = 2e3\n"
                             "poisson = 0.3\nplastic = { cohesion = 20, friction = 0 }\nviscosity = 120\n"
                             "redistribution = 1\ntensile_strength = 1e4\n"
                             "[[body]]\nmaterial = \"honey\"\n"
                             "shape = { cylinder = { radius = 0.03, height = 0.06 }, at = [0, 0.03, 0] }\n"
                             "[[boundary]]\ncondition = \"no-slip\"\n"
                             "shape = { cylinder = { radius = 0.1, height = 0.02 }, at = [0, -0.01, 0] }\n");
  const Model model = assemble(scene);
  const auto open = open_alone({"openmp_float", "openmp", Precision::single_precision});
  Simulation simulation(*open, scene, model);
  double residual = 0, error = 0;
  std::size_t most = 0, taken = 0;
  for (int k = 0; k < 150; ++k) {
    simulation.step();
    for (const StepStatistics& row : simulation.take_statistics()) {
      residual = std::max(residual, row.residual);
      error = std::max(error, row.density_error);
      most = std::max<std::size_t>(most, row.iterations);
      taken += row.iterations;
    }
  }
  double low = 1, wide = 0;
  for (const Vector3& p : simulation.positions())
    low = std::min(low, p.y()), wide = std::max(wide, std::hypot(p.x(), p.z()));
  report("iterations in the mean", double(taken) / 150);
  report("radius at the end, m", wide);
  expect_below("largest residual, relative", residual, 1e-3);
  expect_below("iterations of the longest step", double(most), 100);
  expect_below("largest mean |C| inside", error, 0.02);
  EXPECT_GT(wide, 0.035) << "it spreads";
  EXPECT_GT(low, 0) << "and stays on the plate";
}

} // namespace
} // namespace pliant::test
