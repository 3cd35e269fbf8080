// Fluids with a tensile strength: what is drawn out gets thinner, not less dense, up to what it bears.
#include "tests/support/fluids.h"

namespace pliant::test {
namespace {

class FluidTension : public OnEachDevice {};
INSTANTIATE_TEST_SUITE_P(Devices, FluidTension, testing::ValuesIn(device_choices()), ChoiceName());

constexpr double spacing = 0.0625, step = 0x1p-7;
constexpr int across = 9, along = 24;

/// A viscous bar whose particles part from its middle along y, at a rate that makes it 1 + `strain` times as
/// long in 32 steps; nothing acts on it.
Stage drawn(double strain, double strength) {
  Stage stage = fluid_stage(lattice(across, along, across, spacing), spacing, step);
  stage.scene.simulation.gravity = Vector3::Zero();
  Material& honey = stage.scene.materials[0];
  honey.redistribution = 1;
  honey.tensile_strength = strength;
  for (std::size_t i = 0; i < stage.model.velocity.size(); ++i)
    stage.model.velocity[i] = {
        0, (stage.model.position[i].y() - (along - 1) / 2. * spacing) * strain / (32 * step), 0};
  return stage;
}

struct Drawn {
  double error = 0;  ///< mean |C| inside at the end
  double width = 0;  ///< rms distance from the axis in the middle third, over that at the start
  double length = 0; ///< of the whole, over that at the start
  Vector3 momentum;
};
Drawn draw(Device& device, const Stage& stage) {
  Simulation simulation(device, stage.scene, stage.model);
  const auto look = [&](Drawn& found) {
    const Points at = simulation.positions();
    double low = 1e9, high = -1e9, squares = 0, count = 0;
    for (const Vector3& p : at) low = std::min(low, p.y()), high = std::max(high, p.y());
    const double middle = (low + high) / 2, axis = (across - 1) / 2. * spacing;
    for (const Vector3& p : at)
      if (std::abs(p.y() - middle) < (high - low) / 6)
        squares += std::pow(p.x() - axis, 2) + std::pow(p.z() - axis, 2), ++count;
    found.width = std::sqrt(squares / count);
    found.length = high - low;
  };
  Drawn start, end;
  look(start);
  for (int k = 0; k < 32; ++k) simulation.step();
  look(end);
  const StepStatistics row = simulation.take_statistics().back();
  end.error = row.density_error, end.momentum = row.momentum;
  end.width /= start.width, end.length /= start.length;
  return end;
}

// Of constant volume a bar that is L times as long is L^(-1/2) times as wide.
TEST_P(FluidTension, WhatIsDrawnOutGetsThinner) {
  const auto open = device();
  const Drawn firm = draw(*open, drawn(0.25, 1e6)), loose = draw(*open, drawn(0.25, 0));
  report("length", firm.length);
  report("width", firm.width);
  report("mean |C| inside without strength", loose.error);
  EXPECT_GT(firm.length, 1.15);
  EXPECT_GT(loose.error, 0.1);
  EXPECT_GT(loose.width, 1);
  expect_below("mean |C| inside", firm.error, 0.02);
  expect_below("width away from that of constant volume", std::abs(firm.width * std::sqrt(firm.length) - 1),
               0.03);
  const double momentum = 1000 * std::pow(spacing, 3) * across * across * along * 0.25 / (32 * step);
  expect_below("momentum, of mass times the rate times a spacing",
               firm.momentum.norm() / (momentum * spacing), 1e-3);
}

// p h^2 m / rho^2 bounds the multipliers: a hundredth of the stress that would hold it lets it part.
TEST_P(FluidTension, BeyondItsStrengthItParts) {
  const auto open = device();
  const Drawn weak = draw(*open, drawn(0.25, 0.1)), none = draw(*open, drawn(0.25, 0));
  report("mean |C| inside", weak.error);
  EXPECT_GT(weak.error, 0.5 * none.error);
}

} // namespace
} // namespace pliant::test
