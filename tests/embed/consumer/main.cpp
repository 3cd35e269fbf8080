// Opens the CPU backend through Pliant's public headers and sends numbers there and back.
#include "engine/core/error.h"
#include "engine/device/device.h"

#include <cstdio>
#include <vector>

int main() {
  int unused_here = 0; // a warning that Pliant makes an error for itself, and not for others
  try {
    pliant::DeviceRequest request;
    request.backend = "openmp";
    request.precision = pliant::Precision::double_precision;
    const auto device = pliant::open_device(request);
    const std::vector<double> sent{1.0, -2.5, 1e-300};
    pliant::Buffer buffer = device->allocate("numbers", pliant::Type::real, sent.size());
    device->upload(buffer, sent);
    if (device->download_real(buffer) != sent) {
      std::puts("what came back is not what was sent");
      return 1;
    }
    std::printf("%s: %s\n", device->info().backend.c_str(), device->info().name.c_str());
  } catch (const pliant::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return static_cast<int>(error.code());
  }
  return 0;
}
