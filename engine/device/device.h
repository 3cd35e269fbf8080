// The device contract: what a backend promises, and all that the engine knows of it.
//
// A device owns buffers and runs kernels on them, in the order of the calls. It knows how to run a kernel
// from its declaration (kernels/kernel.h), not which kernels there are. Values travel as double at this
// border and are stored as the device's `real`. Nothing here waits for the device except read() and finish().
#pragma once

#include "kernels/kernel.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace pliant {

enum class Precision : std::uint8_t { single_precision, double_precision };

struct DeviceInfo {
  std::string backend;   ///< "openmp" or "gl"
  std::string name;      ///< processor or GL renderer, as its maker calls it
  std::string driver;    ///< version of driver or OpenMP runtime
  bool software = false; ///< a GL that runs on the CPU
  Precision precision = Precision::single_precision;
  unsigned threads = 1;                    ///< of the OpenMP backend
  std::size_t max_buffer_bytes = SIZE_MAX; ///< largest single buffer
};

/// Bytes of one element as a device of this precision stores it.
std::size_t element_bytes(Type type, Precision precision);

/// Memory of a device. A backend derives its own; the engine sees name, type and count.
class BufferStorage {
public:
  BufferStorage(std::string_view name, Type type, std::size_t count, std::size_t bytes)
      : name_(name), type_(type), count_(count), bytes_(bytes) {}
  BufferStorage(const BufferStorage&) = delete;
  BufferStorage& operator=(const BufferStorage&) = delete;
  virtual ~BufferStorage() = default;
  const std::string& name() const { return name_; }
  Type type() const { return type_; }
  std::size_t count() const { return count_; }
  std::size_t bytes() const { return bytes_; }

private:
  std::string name_;
  Type type_;
  std::size_t count_, bytes_;
};

/// Owns a BufferStorage; empty where the plan left the buffer out. Converts to what Args holds.
class Buffer {
public:
  Buffer() = default;
  explicit Buffer(std::unique_ptr<BufferStorage> storage) : storage_(std::move(storage)) {}
  operator BufferStorage*() const { return storage_.get(); } // NOLINT: Args are filled with buffers by name
  BufferStorage* operator->() const { return storage_.get(); }
  std::size_t count() const { return storage_ ? storage_->count() : 0; }
  friend void swap(Buffer& a, Buffer& b) { std::swap(a.storage_, b.storage_); }

private:
  std::unique_ptr<BufferStorage> storage_;
};

/// A read that does not wait: ask now, look later. Nothing computed may depend on when it arrives.
class Readback {
public:
  virtual ~Readback() = default;
  virtual bool ready() = 0;
  /// The values asked for, as bytes in device layout. Waits if it must.
  virtual std::span<const std::byte> wait() = 0;
};

/// Milliseconds spent in each named component since the last call of Device::take_timings().
struct Timing {
  std::string component;
  double milliseconds = 0;
};

class Device {
public:
  Device() = default;
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;
  virtual ~Device() = default;

  virtual const DeviceInfo& info() const = 0;

  /// A buffer of `count` zeroed elements. Throws Error(too_large), naming the limit, when it does not fit.
  virtual Buffer allocate(std::string_view name, Type type, std::size_t count) = 0;
  /// Raw transfers in the device's own layout, `first` and sizes in bytes.
  virtual void write(BufferStorage* buffer, std::size_t first, std::span<const std::byte> bytes) = 0;
  virtual void read(const BufferStorage* buffer, std::size_t first, std::span<std::byte> bytes) = 0;
  virtual void copy(const BufferStorage* from, BufferStorage* to) = 0;
  virtual std::unique_ptr<Readback> request(const BufferStorage* buffer, std::size_t first,
                                            std::size_t bytes) = 0;

  /// Compiles the variant of a kernel that these options name, so that no step has to.
  virtual void prepare(const KernelInfo& kernel, const void* args) = 0;
  virtual void dispatch(const KernelInfo& kernel, const void* args) = 0;
  virtual void finish() = 0;

  /// Names the component that following dispatches are booked on, when timing is on.
  virtual void enter(std::string_view component) = 0;
  virtual void measure(bool on) = 0;
  virtual std::vector<Timing> take_timings() = 0;

  virtual std::size_t bytes_allocated() const = 0; ///< now
  virtual std::size_t bytes_peak() const = 0;
  /// Kernel variants compiled or resolved so far, in order: what tests hold the plan to.
  virtual std::vector<std::string> kernels_prepared() const = 0;

  template <class Args> void run(const Args& args) { dispatch(Args::info(), &args); }

  /// Typed transfers; real and real4 convert between double and the device's precision.
  void upload(BufferStorage* buffer, std::span<const double> values, std::size_t first_real = 0);
  void upload(BufferStorage* buffer, std::span<const Real4<double>> values, std::size_t first = 0);
  void upload(BufferStorage* buffer, std::span<const std::uint32_t> values, std::size_t first = 0);
  std::vector<double> download_real(const BufferStorage* buffer, std::size_t first = 0,
                                    std::size_t count = SIZE_MAX);
  std::vector<Real4<double>> download_real4(const BufferStorage* buffer, std::size_t first = 0,
                                            std::size_t count = SIZE_MAX);
  std::vector<std::uint32_t> download_uint(const BufferStorage* buffer, std::size_t first = 0,
                                           std::size_t count = SIZE_MAX);
};

/// What the user asks for.
struct DeviceRequest {
  std::string backend = "auto"; ///< "auto", "openmp", "gl" or "gl:N"
  Precision precision = Precision::single_precision;
  unsigned threads = 0; ///< 0: as many as there are processors
  bool replay = false;  ///< run every kernel on the CPU too and stop at the first mismatch
};

struct DeviceListing {
  std::string backend, name, driver;
  int index = 0;
  bool software = false;
  bool usable = false;
  std::string missing; ///< what to install, where it is not usable
};

// Implemented beside the backends (backends/registry.cpp): the engine includes no backend.
std::vector<DeviceListing> list_devices();
/// Throws Error(no_device), naming the package to install. `notice` gets the one line that "auto" prints.
std::unique_ptr<Device> open_device(const DeviceRequest& request,
                                    const std::function<void(const std::string&)>& notice = {});

} // namespace pliant
