// The replay device finds a planted mismatch and says where it is.
#include "engine/device/replay.h"
#include "kernels/grid_place.h"
#include "kernels/predict.h"
#include "kernels/residual_control.h"
#include "shaders/common/solver.glsl"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace pliant::test {
namespace {

// A CPU device whose results are spoiled in one element from some dispatch on.
class FaultyDevice final : public Device {
public:
  FaultyDevice(Precision precision, int faulty_dispatch, double fault)
      : device_(openmp::make_device(precision, 1)), faulty_(faulty_dispatch), fault_(fault) {}
  const DeviceInfo& info() const override { return device_->info(); }
  Buffer allocate(std::string_view name, Type type, std::size_t count) override {
    return device_->allocate(name, type, count);
  }
  void write(BufferStorage* buffer, std::size_t first, std::span<const std::byte> bytes) override {
    device_->write(buffer, first, bytes);
  }
  void read(const BufferStorage* buffer, std::size_t first, std::span<std::byte> bytes) override {
    device_->read(buffer, first, bytes);
  }
  void copy(const BufferStorage* from, BufferStorage* to) override { device_->copy(from, to); }
  std::unique_ptr<Readback> request(const BufferStorage* buffer, std::size_t first,
                                    std::size_t bytes) override {
    return device_->request(buffer, first, bytes);
  }
  void prepare(const KernelInfo& kernel, const void* args) override { device_->prepare(kernel, args); }
  void dispatch(const KernelInfo& kernel, const void* args) override {
    device_->dispatch(kernel, args);
    if (++dispatched_ < faulty_) return;
    if (kernel.name == std::string_view("residual_control")) {
      const auto& control = *static_cast<const kernels::residual_control::Args*>(args);
      std::vector<double> solver = device_->download_real(control.solver);
      solver[SOLVER_ACTION] += fault_;
      device_->upload(control.solver, solver);
      return;
    }
    if (kernel.name == std::string_view("grid_place")) { // the first two change places, or one is lost
      const auto& place = *static_cast<const kernels::grid_place::Args*>(args);
      std::vector<std::uint32_t> placed = device_->download_uint(place.placed);
      std::swap(placed[0], placed[1]);
      if (fault_ != 0) placed[0] = placed[1];
      device_->upload(place.placed, placed);
      return;
    }
    const auto& predict = *static_cast<const kernels::predict::Args*>(args);
    auto values = device_->download_real4(predict.displacement);
    values[5].z += fault_;
    device_->upload(predict.displacement, values);
  }
  void finish() override {}
  void enter(std::string_view) override {}
  void measure(bool) override {}
  std::vector<Timing> take_timings() override { return {}; }
  std::size_t bytes_allocated() const override { return device_->bytes_allocated(); }
  std::size_t bytes_peak() const override { return device_->bytes_peak(); }
  std::vector<std::string> kernels_prepared() const override { return device_->kernels_prepared(); }

private:
  std::unique_ptr<Device> device_;
  int faulty_, dispatched_ = 0;
  double fault_;
};

// Runs predict three times, on values that change from run to run.
void run_predict(Device& device) {
  constexpr std::size_t count = 17;
  std::vector<Buffer> buffers;
  for (const char* name : {"velocity", "position", "target", "displacement"})
    buffers.push_back(device.allocate(name, Type::real4, count));
  std::vector<Real4<double>> velocity(count, {1, 2, 3, 1});
  velocity[9].x = std::numeric_limits<double>::quiet_NaN(); // the same on both, so no mismatch
  device.upload(buffers[1], std::vector<Real4<double>>(count, {0, 1, 0, 2}));
  kernels::predict::Args args;
  args.threads = count;
  args.time_step = 0.5;
  args.velocity = buffers[0];
  args.position = buffers[1];
  args.inertia_target = buffers[2];
  args.displacement = buffers[3];
  for (int i = 0; i < 3; ++i) {
    velocity[0].x = i;
    device.upload(buffers[0], velocity);
    device.run(args);
  }
  EXPECT_EQ(device.download_real4(buffers[3])[1].z, 1.5);
}

// Six particles in two cells.
void run_place(Device& device) {
  const Buffer cell = device.allocate("cell_of", Type::uint, 6),
               next = device.allocate("next", Type::uint, 2),
               placed = device.allocate("placed", Type::uint, 6);
  device.upload(cell, std::vector<std::uint32_t>{0, 1, 0, 1, 0, 1});
  device.upload(next, std::vector<std::uint32_t>{0, 3});
  device.run(kernels::grid_place::Args{.threads = 6, .cell_of = cell, .cell_next = next, .placed = placed});
}

// Is a residual of sqrt(2) no larger than the best so far?
void run_control(Device& device, double best) {
  const Buffer partial = device.allocate("residual_partial", Type::real4, 1),
               state = device.allocate("solver", Type::real, SOLVER_ENTRIES);
  device.upload(partial, std::vector<Real4<double>>{{2, 1, 1, 0}});
  std::vector<double> solver(SOLVER_ENTRIES, 0);
  solver[SOLVER_BEST] = best;
  device.upload(state, solver);
  device.run(kernels::residual_control::Args{.threads = kernels::residual_control::group_size,
                                             .iteration = 8,
                                             .partial_count = 1,
                                             .one_minus_rho = 0.5,
                                             .gamma = 1,
                                             .residual_partial = partial,
                                             .solver = state});
}

class Replay : public testing::TestWithParam<DeviceChoice> {};

TEST_P(Replay, AgreesWithAnHonestReference) {
  for (const Precision precision : {Precision::single_precision, Precision::double_precision}) {
    const auto device = make_replay_device(GetParam().open(), openmp::make_device(precision, 1));
    run_predict(*device);
  }
}

TEST_P(Replay, StopsAtAPlantedMismatch) {
  // The largest displacement is 1.5, so 1.5e-3 is allowed.
  for (const double fault :
       {2e-3, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    const auto device = make_replay_device(
        GetParam().open(), std::make_unique<FaultyDevice>(Precision::double_precision, 2, fault));
    try {
      run_predict(*device);
      FAIL() << "a fault of " << fault << " went unnoticed";
    } catch (const Error& error) {
      const std::string text = error.what();
      EXPECT_EQ(error.code(), ExitCode::internal);
      for (const char* part : {"dispatch 2", "'predict'", "'displacement'", "element 5.z", "1.5"})
        EXPECT_NE(text.find(part), std::string::npos) << part << " is not in: " << text;
    }
  }
}

// A float's sqrt(2) is below the true one, which a double has: of a best that is that float, one device says
// that it is reached, and the other that it is not.
TEST_P(Replay, ADecisionAtATieIsNoMismatch) {
  const double float_root = std::sqrt(2.0f);
  ASSERT_LT(float_root, std::sqrt(2.0));
  const auto device =
      make_replay_device(GetParam().open(), openmp::make_device(Precision::double_precision, 1));
  run_control(*device, float_root);
  if (!GetParam().gl()) {
    const bool single = device->info().precision == Precision::single_precision;
    EXPECT_EQ(replay_ties(*device), single ? 2u : 0u); // the decision, and the iteration that is kept
  }
  EXPECT_EQ(replay_ties(*openmp::make_device(Precision::single_precision, 1)), 0u);
}

TEST_P(Replay, ADecisionThatIsNotAtATieIs) {
  for (const double best : {1.41, 1.42}) {
    const auto device = make_replay_device(GetParam().open(),
                                           std::make_unique<FaultyDevice>(Precision::double_precision, 1, 1));
    try {
      run_control(*device, best);
      FAIL() << "a wrong decision went unnoticed";
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("'solver', element 1:"), std::string::npos) << error.what();
    }
  }
}

TEST_P(Replay, AKernelThatLeavesTheOrderOpenIsHeldToItsNumbers) {
  for (const double fault : {0., 1.}) {
    const auto device = make_replay_device(
        GetParam().open(), std::make_unique<FaultyDevice>(Precision::double_precision, 1, fault));
    if (fault == 0)
      run_place(*device);
    else
      EXPECT_THROW(run_place(*device), Error);
  }
}

TEST_P(Replay, LetsRoundingPass) {
  const auto device = make_replay_device(
      GetParam().open(), std::make_unique<FaultyDevice>(Precision::double_precision, 2, 1e-3));
  run_predict(*device);
}

TEST_P(Replay, IsTheLiveDeviceToTheRest) {
  const auto device =
      make_replay_device(GetParam().open(), openmp::make_device(Precision::single_precision, 1));
  EXPECT_EQ(device->info().backend, GetParam().gl() ? "gl" : "openmp");
  EXPECT_NE(&unwrapped(*device), device.get());
  EXPECT_EQ(gl::is_gl(*device), GetParam().gl());
}

INSTANTIATE_TEST_SUITE_P(Devices, Replay, testing::ValuesIn(device_choices()), ChoiceName());

} // namespace
} // namespace pliant::test
