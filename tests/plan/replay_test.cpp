// The replay switch: a small scene with obstacles, each kernel run on the GL device and on the CPU.
#include "engine/core/error.h"
#include "engine/device/replay.h"
#include "engine/solver/simulation.h"
#include "tests/plan/scenes.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

namespace pliant::test {
namespace {

TEST(ReplaySwitch, AScenesKernelsAgree) {
  std::string backend = "openmp"; // against itself where there is no GL
  for (const DeviceChoice& choice : device_choices())
    if (choice.gl()) backend = "gl";
  if (backend != "gl") std::printf("no GL device: the CPU is replayed against itself\n");
  const std::unique_ptr<Device> device = open_device({.backend = backend, .replay = true});
  EXPECT_NE(&unwrapped(*device), device.get());
  PlanScene made = elastic_only("corotated", lattice_box(5, 5, 5, 0.02));
  made.scene.solver.restore_momentum = true;
  made.scene.solver.iterations = 24;
  made.request.statistics = true;
  made.scene.boundaries = {floor_below()};
  made.scene.boundaries[0].shape.offset = -0.01; // where its lowest particles touch
  made.scene.boundaries[0].friction = 0.4;
  Boundary ball;
  ball.shape.kind = Shape::Kind::sphere;
  ball.shape.radius = 0.03;
  ball.shape.at = {0.04, -0.03, 0.04};
  made.scene.boundaries.push_back(ball);
  Simulation simulation(*device, made.scene, made.model, made.request);
  for (int step = 0; step < 4; ++step) simulation.step();
  const std::vector<StepStatistics> rows = simulation.take_statistics();
  ASSERT_EQ(rows.size(), 4u);
  for (const StepStatistics& row : rows) EXPECT_EQ(row.not_finite, 0u);
}

} // namespace
} // namespace pliant::test
