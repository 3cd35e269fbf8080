// Devices by name.
#include "engine/device/replay.h"
#include "tests/support/devices.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace pliant::test {
namespace {

using testing::HasSubstr;

std::unique_ptr<Device> open(const std::string& backend, Precision precision = Precision::single_precision) {
  DeviceRequest request;
  request.backend = backend;
  request.precision = precision;
  return open_device(request);
}

void expect_refusal(const std::string& backend, Precision precision, ExitCode code, const char* part) {
  try {
    open(backend, precision);
    ADD_FAILURE() << backend << " was opened";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    EXPECT_THAT(error.what(), HasSubstr(part));
  }
}

TEST(Registry, AutoTakesAGpuOrTheProcessorNeverASoftwareGl) {
  const auto listings = list_devices();
  const bool gpu = std::any_of(listings.begin(), listings.end(), [](const DeviceListing& one) {
    return one.backend == "gl" && one.usable && !one.software;
  });
  DeviceRequest request;
  std::vector<std::string> notices;
  const auto device = open_device(request, [&](const std::string& line) { notices.push_back(line); });
  EXPECT_EQ(device->info().backend, gpu ? "gl" : "openmp");
  EXPECT_FALSE(device->info().software);
  ASSERT_EQ(notices.size(), 1u);
  EXPECT_THAT(notices[0], HasSubstr(device->info().name));
  EXPECT_EQ(open("auto", Precision::double_precision)->info().backend, "openmp");
}

TEST(Registry, ListsTheProcessorFirstAndGpusBeforeSoftware) {
  const auto listings = list_devices();
  ASSERT_GE(listings.size(), 2u);
  EXPECT_EQ(listings[0].backend, "openmp");
  int rank = 0;
  for (std::size_t i = 1; i < listings.size(); ++i) {
    EXPECT_EQ(listings[i].backend, "gl");
    const int own = !listings[i].usable ? 2 : listings[i].software ? 1 : 0;
    EXPECT_GE(own, rank);
    rank = own;
    if (!listings[i].usable) EXPECT_THAT(listings[i].missing, HasSubstr("libegl1"));
  }
}

TEST(Registry, RefusesWithAdvice) {
  expect_refusal("cuda", Precision::single_precision, ExitCode::usage, "openmp, gl");
  expect_refusal("gl:x", Precision::single_precision, ExitCode::usage, "number");
  expect_refusal("gl", Precision::double_precision, ExitCode::usage, "float");
  expect_refusal("gl:99", Precision::single_precision, ExitCode::no_device, "");
}

TEST(Registry, WrapsInAReplayOnRequest) {
  DeviceRequest request;
  request.backend = "openmp";
  request.replay = true;
  const auto device = open_device(request);
  EXPECT_EQ(device->info().backend, "openmp");
  EXPECT_NE(&unwrapped(*device), device.get());
}

} // namespace
} // namespace pliant::test
