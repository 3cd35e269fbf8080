// Buffers and transfers: the same on every device.
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <numeric>

namespace pliant::test {
namespace {

class Transfers : public testing::TestWithParam<DeviceChoice> {
protected:
  std::unique_ptr<Device> device = GetParam().open();
};

constexpr std::size_t awkward[] = {1, 15, 16, 17, 127, 1000};

TEST_P(Transfers, NewBuffersAreZero) {
  for (const std::size_t count : awkward) {
    // Dirty memory first, so that a fresh buffer may well get it.
    {
      const Buffer dirty = device->allocate("dirty", Type::uint4, count);
      device->upload(dirty, std::vector<std::uint32_t>(4 * count, 0xdeadbeef));
    }
    const Buffer buffer = device->allocate("fresh", Type::uint4, count);
    EXPECT_EQ(device->download_uint(buffer, 0, 4 * count), std::vector<std::uint32_t>(4 * count, 0)) << count;
  }
}

TEST_P(Transfers, ValuesComeBackAsTheyWent) {
  for (const std::size_t count : awkward) {
    const Buffer reals = device->allocate("reals", Type::real, count);
    const Buffer groups = device->allocate("groups", Type::real4, count);
    const Buffer whole = device->allocate("whole", Type::uint, count);
    std::vector<double> a(count);
    std::vector<Real4<double>> b(count);
    std::vector<std::uint32_t> c(count);
    for (std::size_t i = 0; i < count; ++i) {
      a[i] = 0.5 * static_cast<double>(i) - 3; // exact in float
      b[i] = {a[i], -a[i], 2 * a[i], 1};
      c[i] = 0xffffffffu - static_cast<std::uint32_t>(i);
    }
    device->upload(reals, a);
    device->upload(groups, b);
    device->upload(whole, c);
    EXPECT_EQ(device->download_real(reals), a);
    EXPECT_EQ(device->download_uint(whole), c);
    const auto back = device->download_real4(groups);
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_EQ(back[i].y, b[i].y);
      EXPECT_EQ(back[i].w, 1);
    }
  }
}

TEST_P(Transfers, APartLeavesTheRest) {
  const Buffer buffer = device->allocate("b", Type::uint, 17);
  device->upload(buffer, std::vector<std::uint32_t>(17, 7));
  device->upload(buffer, std::vector<std::uint32_t>{1, 2, 3}, 14);
  std::vector<std::uint32_t> expected(17, 7);
  std::iota(expected.begin() + 14, expected.end(), 1);
  EXPECT_EQ(device->download_uint(buffer), expected);
  EXPECT_EQ(device->download_uint(buffer, 13, 2), (std::vector<std::uint32_t>{7, 1}));
  EXPECT_THROW(device->upload(buffer, std::vector<std::uint32_t>{1, 2}, 16), Error);
}

TEST_P(Transfers, CopyTakesTheSmallerSize) {
  const Buffer from = device->allocate("from", Type::uint, 3), to = device->allocate("to", Type::uint, 5);
  device->upload(from, std::vector<std::uint32_t>{4, 5, 6});
  device->upload(to, std::vector<std::uint32_t>(5, 9));
  device->copy(from, to);
  EXPECT_EQ(device->download_uint(to), (std::vector<std::uint32_t>{4, 5, 6, 9, 9}));
}

// What was asked for is what was there at the time of asking, whatever is written later.
TEST_P(Transfers, AReadbackKeepsTheMomentOfItsRequest) {
  const Buffer buffer = device->allocate("b", Type::uint, 8);
  device->upload(buffer, std::vector<std::uint32_t>(8, 1));
  const auto first = device->request(buffer, 4, 12);
  device->upload(buffer, std::vector<std::uint32_t>(8, 2));
  const auto second = device->request(buffer, 0, 32);
  const auto values = [](Readback& readback) {
    const auto bytes = readback.wait();
    std::vector<std::uint32_t> result(bytes.size() / 4);
    std::copy(bytes.begin(), bytes.end(), std::as_writable_bytes(std::span(result)).begin());
    return result;
  };
  EXPECT_EQ(values(*second), std::vector<std::uint32_t>(8, 2));
  EXPECT_EQ(values(*first), std::vector<std::uint32_t>(3, 1));
  EXPECT_TRUE(first->ready());
  EXPECT_EQ(values(*first), std::vector<std::uint32_t>(3, 1)) << "a second look";
}

TEST_P(Transfers, AReadbackBecomesReadyWithoutWaiting) {
  const Buffer buffer = device->allocate("b", Type::uint, 8);
  const auto readback = device->request(buffer, 0, 32);
  device->finish();
  EXPECT_TRUE(readback->ready());
}

TEST_P(Transfers, MemoryIsCounted) {
  const std::size_t before = device->bytes_allocated();
  {
    const Buffer buffer = device->allocate("b", Type::uint, 100);
    EXPECT_EQ(device->bytes_allocated(), before + 400);
  }
  EXPECT_EQ(device->bytes_allocated(), before);
  EXPECT_GE(device->bytes_peak(), before + 400);
}

TEST_P(Transfers, BuffersMayOutliveTheirDevice) {
  if (!GetParam().gl()) GTEST_SKIP() << "a promise of the GL device";
  Buffer buffer = device->allocate("b", Type::uint, 4);
  auto readback = device->request(buffer, 0, 16);
  device.reset();
  EXPECT_EQ(readback->wait().size(), 16u);
}

TEST_P(Transfers, ABufferBeyondTheLimitIsRefusedByName) {
  if (!GetParam().gl()) GTEST_SKIP() << "a limit of the GL device";
  const std::size_t limit = device->info().max_buffer_bytes;
  const std::size_t before = device->bytes_allocated();
  try {
    const Buffer buffer = device->allocate("huge", Type::real4, limit / 16 + 1);
    FAIL() << "more than the limit was allocated";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::too_large);
    const std::string text = error.what();
    EXPECT_NE(text.find("GL_MAX_SHADER_STORAGE_BLOCK_SIZE"), std::string::npos) << text;
    EXPECT_NE(text.find("'huge' needs " + std::to_string(limit / 16 + 1)), std::string::npos) << text;
  }
  EXPECT_EQ(device->bytes_allocated(), before);
}

INSTANTIATE_TEST_SUITE_P(Devices, Transfers, testing::ValuesIn(device_choices()),
                         [](const auto& info) { return choice_name(info); });

} // namespace
} // namespace pliant::test
