// Patch test: with the boundary held in an affine field, an affine interior is in balance, and a disturbed
// interior returns to it. Held layers are four deep, two horizons and more: the force state of a neighbour
// needs the whole of that neighbour's own neighbourhood.
#include "tests/support/bodies.h"

namespace pliant::test {
namespace {

constexpr double spacing = 0.1;
constexpr int side = 11, layers = 4;

Matrix3 gradient() {
  Matrix3 f;
  f << 1.10, 0.08, -0.03, -0.05, 0.93, 0.06, 0.02, 0.04, 1.05;
  return f;
}

bool boundary(const Vector3& x) {
  const double low = (layers - 0.5) * spacing, high = (side - layers - 0.5) * spacing;
  return (x.array() < low).any() || (x.array() > high).any();
}

class Patch : public OnEachDevice {};

TEST_P(Patch, AffineInteriorIsInBalance) {
  const auto open = device();
  for (const char* law : {"corotated", "ordinary", "projective"}) {
    Stage stage(lattice(side, side, side, spacing), spacing, material_of(law, 1e6, 0.3), 1. / 60);
    Simulation simulation(*open, stage.scene, stage.model);
    const Points rest = simulation.positions();
    Points y;
    for (const Vector3& x : rest) y.push_back(gradient() * x + Vector3(0.1, 0.2, -0.1));
    const std::vector<Vector3> force = simulation.elastic_forces(y);
    double inside = 0, outside = 0;
    for (std::size_t i = 0; i < y.size(); ++i)
      (boundary(rest[i]) ? outside : inside) =
          std::max(boundary(rest[i]) ? outside : inside, force[i].norm());
    // Float: terms of size K |y| with K |xi| strain = the boundary's force; |y| / (|xi| strain) is about 1 /
    // (0.1 0.1), so 100 roundings of 1.2e-7 at most: 1.2e-5, twice for the law's own arithmetic.
    expect_below(std::string(law) + ": largest force inside, of that at the surface", inside / outside,
                 limit(1e-10, 2.4e-5));
  }
}

TEST_P(Patch, DisturbedInteriorReturns) {
  const auto open = device();
  for (const char* law : {"corotated", "ordinary"}) {
    if (GetParam().gl() && std::string(law) == "ordinary") continue; // one law is enough where it takes long
    Stage stage(lattice(side, side, side, spacing), spacing, material_of(law, 1e6, 0.3), 1. / 60);
    const Points rest = stage.model.position;
    std::mt19937 random(7);
    stage.move([](const Vector3& x) -> Vector3 { return gradient() * x; });
    Points affine = stage.model.position;
    for (std::size_t i = 0; i < rest.size(); ++i) {
      const Vector3 noise = 0.2 * spacing * random_vector(random);
      if (boundary(rest[i])) {
        stage.model.held.push_back({static_cast<std::uint32_t>(i), 0});
      } else {
        stage.model.position[i] += noise;
      }
    }
    stage.model.motions = {Motion{}};
    stage.scene.solver.iterations = 400;
    stage.scene.solver.tolerance = 1e-9;
    Simulation simulation(*open, stage.scene, stage.model);
    for (int k = 0; k < (GetParam().gl() ? 15 : 30); ++k) simulation.step();
    // Float: positions are stored to 6e-8 of a metre, 6e-7 of a spacing; the block is two spacings from its
    // boundary everywhere, so errors do not collect beyond a few of these.
    expect_below(std::string(law) + ": largest distance from the affine field, spacings",
                 largest_difference(simulation.positions(), affine) / spacing, limit(1e-9, 4e-6));
  }
}

INSTANTIATE_TEST_SUITE_P(Physics, Patch, testing::ValuesIn(device_choices()), ChoiceName());

} // namespace
} // namespace pliant::test
