// The backends of this build, by name.
#include "engine/device/device.h"

#include "backends/openmp/device.h"
#include "engine/core/error.h"
#include "engine/device/replay.h"
#ifdef PLIANT_WITH_GL
#include "backends/gl/gl_device.h"
#endif

#include <algorithm>
#include <charconv>

namespace pliant {

namespace {

std::vector<DeviceListing> gl_devices() {
#ifdef PLIANT_WITH_GL
  return gl::describe_all();
#else
  DeviceListing none;
  none.backend = "gl";
  none.name = "OpenGL";
  none.missing = "this build has no GL backend; configure with -DPLIANT_GL=ON";
  return {none};
#endif
}

std::unique_ptr<Device> open_gl([[maybe_unused]] int index) {
#ifdef PLIANT_WITH_GL
  return gl::make_device(index);
#else
  throw Error(ExitCode::no_device, gl_devices().front().missing);
#endif
}

std::unique_ptr<Device> open_auto(const DeviceRequest& request,
                                  const std::function<void(const std::string&)>& notice) {
  std::unique_ptr<Device> device;
  if (request.precision == Precision::single_precision) {
    const std::vector<DeviceListing> listings = gl_devices();
    const auto gpu = std::find_if(listings.begin(), listings.end(),
                                  [](const DeviceListing& one) { return one.usable && !one.software; });
    if (gpu != listings.end()) device = open_gl(gpu->index);
  }
  if (!device) device = openmp::make_device(request.precision, request.threads); // rather than a software GL
  if (notice) notice("backend auto: " + device->info().backend + ", " + device->info().name);
  return device;
}

// "gl" is device 0, "gl:N" device N.
int gl_index(const std::string& backend) {
  if (backend == "gl") return 0;
  int index = -1;
  const char *first = backend.data() + 3, *last = backend.data() + backend.size();
  const auto [end, error] = std::from_chars(first, last, index);
  if (error != std::errc() || end != last || index < 0)
    throw Error(ExitCode::usage, "backend '" + backend + "': after gl: comes the number of a device (see pliant doctor)");
  return index;
}

std::unique_ptr<Device> open_named(const DeviceRequest& request,
                                   const std::function<void(const std::string&)>& notice) {
  const std::string& backend = request.backend;
  if (backend == "auto") return open_auto(request, notice);
  if (backend == "openmp") return openmp::make_device(request.precision, request.threads);
  if (backend == "gl" || backend.rfind("gl:", 0) == 0) {
    const int index = gl_index(backend);
    if (request.precision == Precision::double_precision)
      throw Error(ExitCode::usage, "the GL backend computes in float; for double use --backend openmp");
    return open_gl(index);
  }
  throw Error(ExitCode::usage, "unknown backend '" + backend + "'; there are auto, openmp, gl and gl:N");
}

} // namespace

std::vector<DeviceListing> list_devices() {
  std::vector<DeviceListing> listings{openmp::describe()};
  for (DeviceListing& listing : gl_devices()) listings.push_back(std::move(listing));
  return listings;
}

std::unique_ptr<Device> open_device(const DeviceRequest& request,
                                    const std::function<void(const std::string&)>& notice) {
  std::unique_ptr<Device> device = open_named(request, notice);
  if (!request.replay) return device;
  std::unique_ptr<Device> reference = openmp::make_device(device->info().precision, request.threads);
  return make_replay_device(std::move(device), std::move(reference));
}

} // namespace pliant
