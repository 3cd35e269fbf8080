// examples/dripping.toml: how long the thread gets by which a drop hangs, with and without redistribution
// (Fig. 10 of He, Wang and Wu 2017).
#include "tests/support/examples.h"
#include "tests/support/fluids.h"

namespace pliant::test {
namespace {

/// How far below the ceiling, m, what is still in one piece with it reaches; particles 1.5 spacings apart
/// are.
double thread(const Points& at, double spacing) {
  std::vector<std::uint32_t> stack;
  std::vector<bool> seen(at.size(), false);
  double lowest = 0;
  for (std::uint32_t i = 0; i < at.size(); ++i)
    if (at[i].y() > -spacing) stack.push_back(i), seen[i] = true;
  while (!stack.empty()) {
    const Vector3 here = at[stack.back()];
    stack.pop_back();
    lowest = std::min(lowest, here.y());
    for (std::uint32_t j = 0; j < at.size(); ++j)
      if (!seen[j] && (at[j] - here).squaredNorm() < 2.25 * spacing * spacing)
        stack.push_back(j), seen[j] = true;
  }
  return -lowest;
}

double longest_thread(const std::vector<std::string>& overrides) {
  std::vector<std::string> all{"simulation.end=0.36"};
  all.insert(all.end(), overrides.begin(), overrides.end());
  const Scene scene = example_scene("dripping", all);
  const Model model = assemble(scene);
  const auto device = open_alone({"openmp_float", "openmp", Precision::single_precision});
  Simulation simulation(*device, scene, model);
  double longest = 0;
  int k = 0;
  run_scene(simulation, scene, [&](const Points& at) {
    if (++k % 4 == 0) longest = std::max(longest, thread(at, scene.simulation.spacing));
  });
  return longest;
}

TEST(FluidDripping, RedistributionKeepsTheThreadWhole) {
  const double without = longest_thread({"materials.honey.redistribution=0"}), with = longest_thread({}),
               printed = longest_thread({"fluid.redistribution_form=printed"});
  report("longest thread without redistribution, m", without);
  report("longest thread with all of it, m", with);
  report("longest thread with Eq. 24 as printed, m", printed);
  expect_above("with over without", with / without, 1.5);
  expect_above("with over that of Eq. 24 as printed", with / printed, 1.2);
}

} // namespace
} // namespace pliant::test
