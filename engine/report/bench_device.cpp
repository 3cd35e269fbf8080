// See bench_device.h.
#include "engine/report/bench_device.h"

#include <cstring>

namespace pliant {

void BenchDevice::dispatch(const KernelInfo& kernel, const void* args) {
  if (elapsed() > limit_) throw TimeUp();
  if (std::string_view(kernel.name) == "chebyshev_step") ++iterations_;
  if (!timing_) {
    device_.dispatch(kernel, args);
    return;
  }
  device_.finish();
  const auto start = Clock::now();
  device_.dispatch(kernel, args);
  device_.finish();
  KernelSamples& samples = samples_[kernel.name];
  samples.milliseconds.push_back(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
  if (samples.bytes > 0) return;
  for (const Field& field : kernel.fields) {
    if (field.role == Role::option || field.role == Role::parameter) continue;
    BufferStorage* buffer = nullptr;
    std::memcpy(&buffer, static_cast<const std::byte*>(args) + field.offset, sizeof buffer);
    if (!buffer) continue;
    samples.bytes += static_cast<double>(buffer->bytes()) * (field.role == Role::inout ? 2 : 1);
    samples.bonds = samples.bonds || std::string_view(field.name) == "bond";
  }
}

} // namespace pliant
