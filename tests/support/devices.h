// Every device of this machine, for tests that run one body on each. What is absent is printed, once, as skipped.
#pragma once

#include "backends/openmp/device.h"
#include "engine/core/error.h"
#include "engine/device/device.h"
#ifndef PLIANT_TESTS_WITHOUT_GL
#include "backends/gl/gl_device.h"
#endif

#include <cstdio>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

namespace pliant::test {

/// How to open a device: as the parameter of a test, `name` is what GoogleTest shows.
struct DeviceChoice {
  std::string name;
  std::string backend;
  Precision precision = Precision::single_precision;

  std::unique_ptr<Device> open() const {
    DeviceRequest request;
    request.backend = backend;
    request.precision = precision;
    return open_device(request);
  }
  bool gl() const { return backend.rfind("gl", 0) == 0; }
  /// Rounding of one operation on this device.
  double epsilon() const { return precision == Precision::double_precision ? 0x1p-52 : 0x1p-23; }
  friend std::ostream& operator<<(std::ostream& out, const DeviceChoice& choice) { return out << choice.name; }
};

/// openmp in float and in double, and each usable GL device.
inline const std::vector<DeviceChoice>& device_choices() {
  static const std::vector<DeviceChoice> choices = [] {
    std::vector<DeviceChoice> found{{"openmp_float", "openmp", Precision::single_precision},
                                    {"openmp_double", "openmp", Precision::double_precision}};
    for (const DeviceListing& listing : list_devices()) {
      if (listing.backend != "gl") continue;
      const std::string index = std::to_string(listing.index);
      if (listing.usable)
        found.push_back({"gl_" + index, "gl:" + index, Precision::single_precision});
      else
        std::printf("[ SKIPPED  ] gl device '%s': %s\n", listing.name.c_str(), listing.missing.c_str());
    }
    return found;
  }();
  return choices;
}

/// For INSTANTIATE_TEST_SUITE_P(…, devices, testing::ValuesIn(device_choices()), choice_name).
inline std::string choice_name(const auto& info) { return info.param.name; }

} // namespace pliant::test
