// Runs one kernel on one device from values by name, and compares every element of what it wrote with a plain
// formula.
//
//   Values in                 options, parameters, tables and buffers by the names of the declaration, as
//   doubles Expected out              value and scale of every element of an output buffer, sentinels
//   included expect_kernel<Args>(…)    runs, compares, and prints the worst error over the limit
//
// An error is counted in roundings: |got - wanted| / (epsilon of the device * scale), where scale is the sum
// of the magnitudes of the terms. scale 0 means bit for bit; an infinite scale asks for a finite value only,
// for elements that the formula does not determine, which the test then checks by their properties. On a GL
// device the same run on the CPU in float must agree within the limit too.
#pragma once

#include "tests/support/devices.h"

#include <fmt/format.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace pliant::test {

using Values = std::map<std::string, std::vector<double>>;

inline constexpr double sentinel = -12345;
inline constexpr double anything = std::numeric_limits<double>::infinity();
inline constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// As every device gets it: exact in float.
inline double rounded(double value) {
  return static_cast<double>(static_cast<float>(value));
}

struct Expected {
  std::vector<double> value, scale;
  Expected() = default;
  explicit Expected(std::size_t size, double fill = sentinel) : value(size, fill), scale(size, 0) {}
  /// Starts as what the buffer held before.
  explicit Expected(const std::vector<double>& before) : value(before), scale(before.size(), 0) {}
  void set(std::size_t at, double wanted, double size = 0) { value[at] = wanted, scale[at] = size; }
};

/// One open device a choice: its programs are compiled once. Closed before the program ends.
class OpenDevices : public testing::Environment {
public:
  static Device& of(const DeviceChoice& choice) {
    std::unique_ptr<Device>& device = all()[choice.name];
    if (!device) device = choice.open();
    return *device;
  }
  struct Worst {
    double error = 0, limit = 0;
  };
  static std::map<std::string, Worst>& worst() {
    static std::map<std::string, Worst> found;
    return found;
  }
  void TearDown() override {
    for (const auto& [name, found] : worst())
      std::printf("  %-36s largest error %8.2f roundings, limit %6.0f\n", name.c_str(), found.error,
                  found.limit);
    all().clear();
  }

private:
  static std::map<std::string, std::unique_ptr<Device>>& all() {
    static std::map<std::string, std::unique_ptr<Device>> devices;
    return devices;
  }
};
inline testing::Environment* const open_devices = testing::AddGlobalTestEnvironment(new OpenDevices);

inline bool is_whole(const Field& field) {
  return field.type == Type::uint || field.type == Type::uint4 || field.role == Role::option;
}

/// Runs a kernel; returns its outputs, every element.
template <class Args> Values run_kernel(Device& device, std::uint32_t threads, const Values& in) {
  Args args;
  args.threads = threads;
  std::map<std::string, Buffer> buffers;
  for (const auto& [name, values] : in) {
    const auto& fields = Args::info().fields;
    const auto field = std::find_if(fields.begin(), fields.end(),
                                    [&, key = &name](const Field& f) { return *key == f.name; });
    if (field == fields.end()) {
      ADD_FAILURE() << Args::info().name << " has no field '" << name << "'";
      continue;
    }
    char* const at = reinterpret_cast<char*>(&args) + field->offset;
    const std::vector<std::uint32_t> whole = is_whole(*field)
                                                 ? std::vector<std::uint32_t>(values.begin(), values.end())
                                                 : std::vector<std::uint32_t>{};
    if (field->role == Role::option || field->role == Role::parameter) {
      if (is_whole(*field))
        std::memcpy(at, whole.data(), sizeof(std::uint32_t));
      else
        std::memcpy(at, values.data(), sizeof(double));
      continue;
    }
    const std::size_t width = field->type == Type::real4 || field->type == Type::uint4 ? 4 : 1;
    Buffer& buffer = buffers[name] = device.allocate(name, field->type, values.size() / width);
    if (is_whole(*field))
      device.upload(buffer, whole);
    else
      device.upload(buffer, values);
    BufferStorage* const storage = buffer;
    std::memcpy(at, static_cast<const void*>(&storage), sizeof(void*));
  }
  device.run(args);
  Values out;
  for (const Field& field : Args::info().fields) {
    if ((field.role != Role::out && field.role != Role::inout) || !buffers.count(field.name)) continue;
    std::vector<double>& values = out[field.name];
    const Buffer& buffer = buffers[field.name];
    if (field.type == Type::uint) {
      const std::vector<std::uint32_t> whole = device.download_uint(buffer);
      values.assign(whole.begin(), whole.end());
    } else if (field.type == Type::real) {
      values = device.download_real(buffer);
    } else {
      for (const Real4<double>& v : device.download_real4(buffer))
        values.insert(values.end(), {v.x, v.y, v.z, v.w});
    }
  }
  return out;
}

inline std::string suite_of(const DeviceChoice& choice, const char* kernel) {
  return std::string(kernel) + " on " + choice.name;
}

/// `got` against `wanted`; returns the largest error in roundings.
inline double compare_values(const std::string& what, const std::vector<double>& got,
                             const std::vector<double>& wanted, const std::vector<double>& scale,
                             double epsilon, double limit) {
  EXPECT_EQ(got.size(), wanted.size()) << what;
  double worst = 0;
  int failures = 0;
  for (std::size_t k = 0; k < std::min(got.size(), wanted.size()); ++k) {
    if (std::isnan(wanted[k]) && std::isnan(got[k])) continue;
    double error = 0;
    if (scale[k] == anything)
      error = std::isfinite(got[k]) ? 0 : anything;
    else if (got[k] != wanted[k])
      error = scale[k] > 0 ? std::abs(got[k] - wanted[k]) / (epsilon * scale[k]) : anything;
    if (!(error <= limit) && ++failures <= 4)
      ADD_FAILURE() << what << ", element " << k << ": " << got[k] << " instead of " << wanted[k] << ", "
                    << error << " roundings of " << scale[k] << "; limit " << limit;
    worst = std::max(worst, std::isnan(error) ? anything : error);
  }
  return worst;
}

/// Runs a kernel and compares its outputs; `limit` in roundings. Returns the outputs, for checks of
/// properties.
template <class Args>
Values expect_kernel(const DeviceChoice& choice, std::uint32_t threads, const Values& in,
                     const std::map<std::string, Expected>& wanted, double limit) {
  for (const Field& field : Args::info().fields) {
    if (is_whole(field) || !in.count(field.name)) continue;
    for (const double value : in.at(field.name))
      EXPECT_TRUE(value == rounded(value) || std::isnan(value))
          << field.name << " is not exact in float: " << value;
  }
  const std::string what = suite_of(choice, Args::info().name);
  Values got = run_kernel<Args>(OpenDevices::of(choice), threads, in);
  auto& worst = OpenDevices::worst()[what];
  worst.limit = std::max(worst.limit, limit);
  EXPECT_EQ(got.size(), wanted.size()) << what << ": every output has an expectation";
  for (const auto& [name, expected] : wanted)
    worst.error =
        std::max(worst.error, compare_values(fmt::format("{}, {}", what, name), got.at(name), expected.value,
                                             expected.scale, choice.epsilon(), limit));
  if (!choice.gl()) return got;
  const DeviceChoice& host = device_choices().front(); // openmp, float
  const Values twin = run_kernel<Args>(OpenDevices::of(host), threads, in);
  for (const auto& [name, expected] : wanted)
    compare_values(fmt::format("{} against the CPU in float, {}", what, name), got.at(name), twin.at(name),
                   expected.scale, choice.epsilon(), limit);
  return got;
}

/// After `in` was spoiled somewhere: elements outside `reached` must be as they were, those of `certain` not
/// finite.
inline void expect_contained(const std::string& what, const std::vector<double>& clean,
                             const std::vector<double>& spoiled, std::size_t width,
                             const std::vector<std::size_t>& reached, std::size_t certain) {
  bool spoiled_there = false;
  for (std::size_t k = 0; k < clean.size(); ++k) {
    if (k / width == certain) spoiled_there = spoiled_there || !std::isfinite(spoiled[k]);
    if (std::find(reached.begin(), reached.end(), k / width) != reached.end()) continue;
    EXPECT_TRUE(clean[k] == spoiled[k] || (std::isnan(clean[k]) && std::isnan(spoiled[k])))
        << what << ": not a number came as far as element " << k;
  }
  EXPECT_TRUE(spoiled_there) << what << ": not a number was lost at particle " << certain;
}

#define PLIANT_ON_EVERY_DEVICE(Suite)                                                                        \
  class Suite : public testing::TestWithParam<DeviceChoice> {};                                              \
  INSTANTIATE_TEST_SUITE_P(Devices, Suite, testing::ValuesIn(device_choices()), ChoiceName())

} // namespace pliant::test
