// Extreme states: a body flattened, collapsed, mirrored or scrambled comes back (Irving et al. 2004 for the
// law that needs it), the paper's row swap does not, and a bar twisted by a full turn and back stays whole.
#include "tests/support/bodies.h"

namespace pliant::test {
namespace {

constexpr double spacing = 0.1;
constexpr int side = 7;

struct Start {
  const char* name;
  std::function<Vector3(const Vector3&, std::mt19937&)> map;
};

std::vector<Start> starts() {
  const double half = side * spacing / 2;
  return {{"plane", [](const Vector3& x, std::mt19937&) { return Vector3(0, x.y(), x.z()); }},
          {"line", [](const Vector3& x, std::mt19937&) { return Vector3(x.x(), 0, 0); }},
          {"point", [](const Vector3&, std::mt19937&) { return Vector3(0, 0, 0); }},
          {"mirror", [](const Vector3& x, std::mt19937&) { return Vector3(-x.x(), x.y(), x.z()); }},
          {"random",
           [half](const Vector3&, std::mt19937& random) -> Vector3 { return half * random_vector(random); }}};
}

struct Recovered {
  double strain = 0, upright = 0; // rms of bonds; share of particles with det F > 0
  double thickness = 0;           // smallest extent along an axis, spacings
};

Recovered recover(Device& device, const Material& material, const Start& start, unsigned iterations,
                  int steps = 90) {
  Stage stage(lattice(side, side, side, spacing), spacing, material, 1. / 30);
  stage.scene.solver.iterations = iterations;
  stage.scene.solver.tolerance = 1e-3;
  Vector3 centre = Vector3::Zero();
  for (const Vector3& x : stage.model.position) centre += x / static_cast<double>(stage.model.count());
  std::mt19937 random(17);
  stage.move([&](const Vector3& x) { return start.map(x - centre, random); });
  Simulation simulation(device, stage.scene, stage.model);
  for (int k = 0; k < steps; ++k) simulation.step();
  const Points y = simulation.positions();
  Recovered result;
  Vector3 low = y[0], high = y[0];
  for (std::uint32_t i = 0; i < y.size(); ++i) {
    EXPECT_TRUE(y[i].allFinite());
    low = low.cwiseMin(y[i]), high = high.cwiseMax(y[i]);
    if (determinant(deformation_gradient(stage.model, y, i)) > 0) result.upright += 1;
  }
  result.upright /= static_cast<double>(y.size());
  result.strain = rms_bond_strain(stage.model, y);
  result.thickness = (high - low).minCoeff() / spacing;
  return result;
}

class Recovery : public OnEachDevice {};

TEST_P(Recovery, OfTheCorotatedLaw) {
  const auto open = device();
  for (const Start& start : starts()) {
    // A GL that is software takes half a minute for each: two starts there, with fewer iterations.
    if (GetParam().gl() && std::string(start.name) != "plane" && std::string(start.name) != "point") continue;
    const Recovered now =
        recover(*open, material_of("corotated", 1e5, 0.3), start, GetParam().gl() ? 30 : 100);
    expect_below(std::string(start.name) + ": rms strain left", now.strain, 1e-2);
    expect_above(std::string(start.name) + ": share with det F > 0", now.upright, 0.99);
  }
}

TEST_P(Recovery, OfTheProjectiveLawWithClampedValues) {
  if (GetParam().gl()) GTEST_SKIP() << "the corotated law stands for it on a GL that is software";
  const auto open = device();
  for (const Start& start : starts()) {
    const Recovered now = recover(*open, material_of("projective", 1e5, 0.25), start, 100);
    expect_below(std::string(start.name) + ": rms strain left", now.strain, 1e-2);
    expect_above(std::string(start.name) + ": share with det F > 0", now.upright, 0.99);
  }
}

// The paper's own treatment swaps rows where det F < 0; in a plane det F = 0, and no force leaves it, so a
// flat body stays flat for ever. The plane lies askew to the lattice: bonds exactly across it would have no
// direction, and the engine gives such bonds that of their rest state.
TEST(Recovery, TheRowSwapStaysFlat) {
  const auto open = open_double();
  const Matrix3 askew = Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()).toRotationMatrix();
  const Start start{"plane, askew", [&](const Vector3& x, std::mt19937&) -> Vector3 {
                      const Vector3 turned = askew * x;
                      return {0, turned.y(), turned.z()};
                    }};
  Material material = material_of("projective", 1e5, 0.25);
  const Recovered clamped = recover(*open, material, start, 100);
  material.inversion = "swap";
  const Recovered swapped = recover(*open, material, start, 100);
  expect_below("clamped, from a plane askew: rms strain left", clamped.strain, 1e-2);
  expect_above("clamped: share with det F > 0", clamped.upright, 0.99);
  expect_below("row swap, from a plane askew: thickness, spacings (documented failure)", swapped.thickness,
               1e-6);
}

class Twist : public OnEachDevice {};

TEST_P(Twist, AFullTurnAndBack) {
  const auto open = device();
  const double pi = std::acos(-1.0), turn_time = 1;
  const int steps = 60;
  Stage stage(lattice(14, 3, 3, spacing), spacing, material_of("corotated", 1e6, 0.3), turn_time / steps);
  stage.scene.solver.tolerance = 1e-3;
  stage.scene.solver.iterations = GetParam().gl() ? 60 : 300;
  const Points rest = stage.model.position;
  Vector3 centre = Vector3::Zero();
  for (const Vector3& x : rest) centre += x / static_cast<double>(rest.size());
  const double first = centre.x() - 6.5 * spacing, last = centre.x() + 6.5 * spacing;
  stage.hold([&](const Vector3& x) { return x.x() < first + 1.5 * spacing; });
  Motion motion;
  motion.axis = {1, 0, 0};
  motion.about = centre;
  motion.end = turn_time;
  motion.rate = 2 * pi / turn_time;
  stage.hold([&](const Vector3& x) { return x.x() > last - 1.5 * spacing; }, motion);
  Simulation forth(*open, stage.scene, stage.model);
  for (int k = 0; k < steps; ++k) forth.step();
  const Points twisted = forth.positions();
  double upright = 0;
  for (std::uint32_t i = 0; i < twisted.size(); ++i) {
    ASSERT_TRUE(twisted[i].allFinite());
    if (determinant(deformation_gradient(stage.model, twisted, i)) > 0) upright += 1;
  }
  expect_above("twisted by 360 degrees: share with det F > 0", upright / static_cast<double>(twisted.size()),
               1);
  // Halfway along it has turned by about half: it is twisted indeed.
  Snapshot state = forth.snapshot();
  state.step = 0;
  stage.model.motions[1].rate = -motion.rate; // held at a full turn, which is where they began
  Simulation back(*open, stage.scene, stage.model);
  back.restore(state);
  for (int k = 0; k < 2 * steps; ++k) back.step();
  expect_above("twisted: largest distance from rest, spacings", largest_difference(twisted, rest) / spacing,
               1);
  // Float: what the solver's tolerance of 1e-3 leaves of a motion that has died away.
  expect_below("untwisted: largest distance from rest, spacings",
               largest_difference(back.positions(), rest) / spacing, 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Physics, Recovery, testing::ValuesIn(device_choices()), ChoiceName());
INSTANTIATE_TEST_SUITE_P(Physics, Twist, testing::ValuesIn(device_choices()), ChoiceName());

} // namespace
} // namespace pliant::test
