// The replay device finds a planted mismatch and says where it is.
#include "engine/device/replay.h"
#include "kernels/grid_place.h"
#include "kernels/predict.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <limits>

namespace pliant::test {
namespace {

// A CPU device whose results of one dispatch are spoiled in one element.
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
    if (++dispatched_ != faulty_) return;
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
