// Large rotations: a slender cantilever under a dead load at its tip against the elastica, whose tip
// Mattiasson (1981) tabulated from elliptic integrals. The bending rigidity is the body's own, measured at a
// small load: what is tested is that nothing but the shape changes when the beam turns through eighty
// degrees.
#include "tests/support/bodies.h"

namespace pliant::test {
namespace {

constexpr double spacing = 0.1, young = 1e6, poisson = 0.25;
constexpr int layers = 3, length = 60; // twenty times as long as thick

struct Tip {
  double down = 0, back = 0, angle = 0; ///< in lengths of the beam, and degrees
};
struct Tabulated {
  double load; ///< P L^2 / EI
  Tip tip;
};
constexpr Tabulated elastica[] = {{0.25, {.08275, .00412, 7.12}}, {1, {.30172, .05643, 26.43}},
                                  {2, {.49346, .16064, 44.79}},   {4, {.66996, .32894, 64.24}},
                                  {6, {.74457, .43459, 73.55}},   {10, {.81061, .55500, 81.95}}};

class Beam {
public:
  explicit Beam(const Material& material)
      : stage_(lattice(length + 2, layers, layers, spacing), spacing, material, 1000),
        rest_(stage_.model.position), last_(rest_[0].x() + (length + 1) * spacing) {
    stage_.scene.solver.method = "newton";
    stage_.scene.solver.iterations = 2000;
    const double first = rest_[0].x();
    stage_.hold([&](const Vector3& x) { return x.x() < first + 1.5 * spacing; });
  }

  /// At rest under a force downwards at the last layer, by a step so long that inertia is nothing.
  Tip under(double force) {
    stage_.model.loads.clear();
    stage_.model.position = rest_; // by which the loaded particles are chosen
    stage_.load([&](const Vector3& x) { return x.x() > last_ - spacing / 2; }, {0, -force, 0});
    if (!now_.empty()) stage_.model.position = now_;
    const auto open = open_double();
    Simulation simulation(*open, stage_.scene, stage_.model);
    simulation.step();
    now_ = simulation.positions();
    Vector3 moved = Vector3::Zero(), along = Vector3::Zero();
    for (std::size_t i = 0; i < rest_.size(); ++i) {
      if (rest_[i].x() > last_ - spacing / 2) moved += now_[i] - rest_[i], along += now_[i];
      if (std::abs(rest_[i].x() - (last_ - spacing)) < spacing / 2) along -= now_[i];
    }
    moved /= layers * layers * length * spacing;
    return {-moved.y(), -moved.x(), std::atan2(-along.y(), along.x()) * 180 / std::acos(-1.0)};
  }

private:
  Stage stage_;
  Points rest_, now_;
  double last_;
};

TEST(Elastica, ACantileverTurnsAsTheTableSays) {
  Material saint_venant = material_of("stvk", young, poisson),
           neo_hookean = material_of("neo-hookean", young, poisson);
  saint_venant.form = neo_hookean.form = "exact";
  for (const Material& material : {material_of("corotated", young, poisson), saint_venant, neo_hookean}) {
    Beam beam(material);
    const double l = length * spacing, inertia = std::pow(layers * spacing, 4) / 12;
    const double small = 1e-3 * young * inertia / (l * l);
    const double rigidity = small * l * l / (3 * beam.under(small).down); // P L^3 / 3 w
    report(material.law + ": rigidity / EI", rigidity / (young * inertia));
    for (const Tabulated& row : elastica) {
      const Tip tip = beam.under(row.load * rigidity / (l * l));
      std::printf("  load %5.2f: down %.4f (%.4f), back %.4f (%.4f), angle %.2f (%.2f)\n", row.load, tip.down,
                  row.tip.down, tip.back, row.tip.back, tip.angle, row.tip.angle);
      EXPECT_NEAR(tip.down, row.tip.down, 0.01);
      EXPECT_NEAR(tip.back, row.tip.back, 0.01);
      EXPECT_NEAR(tip.angle, row.tip.angle, 1);
    }
  }
}

} // namespace
} // namespace pliant::test
