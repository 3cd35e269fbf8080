// The St. Venant-Kirchhoff bunny of Xu et al., "Reformulating Hyperelastic Materials with Peridynamic
// Modeling" (2018), Fig. 14, and the bars of Fig. 12, from the scenes in examples/, sampled more coarsely.
#include "engine/scene/mesh.h"
#include "engine/scene/scene_parse.h"
#include "tests/support/bodies.h"

#include <filesystem>

namespace pliant::test {
namespace {

Scene example(const std::string& name, const std::vector<std::string>& overrides) {
  return read_scene(std::filesystem::path(PLIANT_SOURCE_DIR) / "examples" / (name + ".toml"), overrides);
}

double height(const Points& points) {
  double low = points[0].y(), high = low;
  for (const Vector3& p : points) low = std::min(low, p.y()), high = std::max(high, p.y());
  return high - low;
}

double upright_share(const Model& model, const Points& y) {
  double count = 0;
  for (std::uint32_t i = 0; i < y.size(); ++i) count += determinant(deformation_gradient(model, y, i)) > 0;
  return count / static_cast<double>(y.size());
}

// Under a force of six times its weight the material collapses in places, where a finite element would be
// inverted and its forces point the wrong way; here the run stays finite, and the body comes back when the
// force ends. At this spacing the ears are two or three particles thick, and a tip may stay folded: a few
// particles are let off.
TEST(FigureFourteen, TheBunnyIsCrushedAndComesBack) {
  const Scene scene = example("bunny-stvk", {"simulation.spacing=0.06"});
  try {
    find_mesh(scene.bodies[0].shape.mesh, scene.file.parent_path());
  } catch (const Error&) {
    GTEST_SKIP() << "the bunny is not installed";
  }
  const Model model = assemble(scene);
  const auto device = open_alone({"openmp", "openmp", Precision::single_precision});
  Simulation simulation(*device, scene, model);
  const Points rest = simulation.positions();
  const auto steps = std::lround(scene.simulation.end / simulation.time_step());
  double least = height(rest), upright = 1;
  for (long k = 0; k < steps; ++k) {
    simulation.step();
    if (k % 4) continue;
    const Points y = simulation.positions();
    for (const Vector3& p : y) ASSERT_TRUE(p.allFinite()) << "step " << k;
    least = std::min(least, height(y));
    upright = std::min(upright, upright_share(model, y));
  }
  const Points y = simulation.positions();
  report("particles", static_cast<double>(model.count()));
  report("least share with det F > 0 on the way", upright);
  expect_below("least height, of that at rest", least / height(rest), 0.6);
  expect_above("share with det F > 0 at the end", upright_share(model, y), 0.99);
  double back = 0;
  for (std::size_t i = 0; i < y.size(); ++i) back += (y[i] - rest[i]).norm() < 0.05 * height(rest);
  expect_above("share back to 5 % of the height", back / static_cast<double>(y.size()), 0.9);
  expect_below("rms strain of bonds at the end", rms_bond_strain(model, y), 0.05);
}

} // namespace
} // namespace pliant::test
