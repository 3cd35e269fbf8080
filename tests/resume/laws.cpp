// Every law goes on from a saved state in the bits of the run that was not interrupted: what it keeps between
// steps is among the persistent buffers.
#include "engine/solver/saved_state.h"
#include "tests/support/bodies.h"

namespace pliant::test {
namespace {

struct Case {
  std::string name;
  Material material;
};

std::vector<Case> cases() {
  const auto made = [](const char* law, const char* form) {
    Material material = material_of(law, 1e5, 0.3);
    material.form = form;
    return material;
  };
  Material basis = made("basis", "");
  basis.volume_basis = {{"A2", 1}};
  basis.bond_basis = {{"A4", 0.5}, {"B1", 0.5}};
  Material directed = made("stvk", "exact");
  directed.anisotropy.given = true;
  directed.anisotropy.strengths = {4, 0.25, 1};
  Material pushed = made("neo-hookean", "bonds");
  pushed.inversion = "clamp";
  Material broken = made("ordinary", "");
  broken.critical_stretch = 0.02;
  return {{"corotated", made("corotated", "")},
          {"ordinary", made("ordinary", "")},
          {"projective", made("projective", "")},
          {"basis", basis},
          {"stvk with directions", directed},
          {"neo-hookean over bonds, clamped", pushed},
          {"neo-hookean", made("neo-hookean", "exact")},
          {"ordinary that breaks", broken}};
}

/// A block that hangs by a held face, thrown sideways and twisted.
Stage thrown(const Material& material, const std::string& method) {
  Stage stage(lattice(5, 4, 4, 0.1), 0.1, material, 1. / 60);
  stage.scene.simulation.gravity = {0, -9.81, 0};
  stage.scene.solver.method = method;
  stage.scene.solver.iterations = 40;
  stage.scene.solver.tolerance = 1e-3;
  const double first = stage.model.position[0].x();
  stage.hold([&](const Vector3& x) { return x.x() < first + 0.05; });
  for (std::size_t i = 0; i < stage.model.count(); ++i) {
    const Vector3& x = stage.model.position[i];
    if (x.x() > first + 0.05) stage.model.velocity[i] = {3 * (x.x() - first), 1 - 4 * x.z(), 4 * x.y()};
  }
  return stage;
}

class Resumed : public OnEachDevice {};

TEST_P(Resumed, EachLawGoesOnInTheSameBits) {
  for (const Case& one : cases())
    for (const char* method : {"chebyshev", "newton"}) {
      if (one.material.law == "projective" && std::string(method) == "newton") continue;
      SCOPED_TRACE(one.name + ", " + method);
      const Stage stage = thrown(one.material, method);
      const auto open = device();
      Simulation whole(*open, stage.scene, stage.model), later(*open, stage.scene, stage.model);
      for (int k = 0; k < 5; ++k) whole.step();
      const SavedState saved = whole.save();
      for (int k = 0; k < 5; ++k) whole.step();
      later.load(saved);
      for (int k = 0; k < 5; ++k) later.step();
      EXPECT_EQ(later.hash(), whole.hash());
      if (one.material.breaks()) {
        const std::vector<double> damage = whole.damage();
        EXPECT_GT(*std::max_element(damage.begin(), damage.end()), 0) << "nothing broke";
        EXPECT_EQ(later.damage(), damage);
      }
    }
}

INSTANTIATE_TEST_SUITE_P(Devices, Resumed, testing::ValuesIn(device_choices()), ChoiceName());

} // namespace
} // namespace pliant::test
