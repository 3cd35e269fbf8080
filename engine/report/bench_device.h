// A device that watches another: it counts dispatches, times each kernel if told to, and ends an entry that
// takes too long.
#pragma once

#include "engine/device/device.h"

#include <chrono>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace pliant {

/// Thrown out of a dispatch when the time of an entry is up.
struct TimeUp : std::runtime_error {
  TimeUp() : std::runtime_error("time is up") {}
};

struct KernelSamples {
  std::vector<double> milliseconds; ///< of each dispatch
  double bytes = 0;                 ///< of the buffers that it declares, once read and once written
  bool bonds = false;               ///< it walks bonds
};

class BenchDevice final : public Device {
public:
  using Clock = std::chrono::steady_clock;

  BenchDevice(Device& device, double limit_seconds)
      : device_(device), limit_(limit_seconds), start_(Clock::now()) {}

  /// From here on every dispatch is waited for and timed.
  void time_kernels() { timing_ = true; }
  /// The entry begins now.
  void restart() {
    start_ = Clock::now();
    iterations_ = 0;
  }
  double elapsed() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  std::size_t iterations() const { return iterations_; } ///< global steps dispatched since restart()
  const std::map<std::string, KernelSamples>& samples() const { return samples_; }

  const DeviceInfo& info() const override { return device_.info(); }
  Buffer allocate(std::string_view name, Type type, std::size_t count) override {
    return device_.allocate(name, type, count);
  }
  void write(BufferStorage* buffer, std::size_t first, std::span<const std::byte> bytes) override {
    device_.write(buffer, first, bytes);
  }
  void read(const BufferStorage* buffer, std::size_t first, std::span<std::byte> bytes) override {
    device_.read(buffer, first, bytes);
  }
  void copy(const BufferStorage* from, BufferStorage* to) override { device_.copy(from, to); }
  std::unique_ptr<Readback> request(const BufferStorage* buffer, std::size_t first,
                                    std::size_t bytes) override {
    return device_.request(buffer, first, bytes);
  }
  void prepare(const KernelInfo& kernel, const void* args) override { device_.prepare(kernel, args); }
  void dispatch(const KernelInfo& kernel, const void* args) override;
  void finish() override { device_.finish(); }
  void enter(std::string_view component) override { device_.enter(component); }
  void measure(bool on) override { device_.measure(on); }
  std::vector<Timing> take_timings() override { return device_.take_timings(); }
  std::size_t bytes_allocated() const override { return device_.bytes_allocated(); }
  std::size_t bytes_peak() const override { return device_.bytes_peak(); }
  std::vector<std::string> kernels_prepared() const override { return device_.kernels_prepared(); }

private:
  Device& device_;
  double limit_;
  Clock::time_point start_;
  bool timing_ = false;
  std::size_t iterations_ = 0;
  std::map<std::string, KernelSamples> samples_;
};

} // namespace pliant
