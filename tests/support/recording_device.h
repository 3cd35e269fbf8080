// A device that passes everything on and writes down which buffers were allocated, which kernels ran, and
// which buffers their variants' shaders name: what a plan is held to.
#pragma once

#include "backends/gl/shader_text.h"
#include "backends/gl/source.h"
#include "engine/device/device.h"

#include <cstring>
#include <map>
#include <set>

namespace pliant::test {

class RecordingDevice final : public Device {
public:
  explicit RecordingDevice(Device& device) : device_(device), allocated_before_(device.bytes_allocated()) {}

  std::map<std::string, std::size_t> allocated; ///< name to bytes, of each buffer ever asked for
  std::set<std::string> dispatched;             ///< variants, e.g. "predict[bdf2=0,loaded=1]"
  std::set<std::string> prepared;               ///< the same
  std::set<std::string> used; ///< names of buffers that a dispatched shader names or a copy fills
  bool twice = false;         ///< two buffers of one name

  const DeviceInfo& info() const override { return device_.info(); }
  Buffer allocate(std::string_view name, Type type, std::size_t count) override {
    twice = !allocated.emplace(name, count * element_bytes(type, info().precision)).second || twice;
    return device_.allocate(name, type, count);
  }
  void write(BufferStorage* buffer, std::size_t first, std::span<const std::byte> bytes) override {
    device_.write(buffer, first, bytes);
  }
  void read(const BufferStorage* buffer, std::size_t first, std::span<std::byte> bytes) override {
    device_.read(buffer, first, bytes);
  }
  void copy(const BufferStorage* from, BufferStorage* to) override {
    used.insert(to->name());
    device_.copy(from, to);
  }
  std::unique_ptr<Readback> request(const BufferStorage* buffer, std::size_t first,
                                    std::size_t bytes) override {
    return device_.request(buffer, first, bytes);
  }
  void prepare(const KernelInfo& kernel, const void* args) override {
    prepared.insert(gl::variant_name(kernel, args));
    device_.prepare(kernel, args);
  }
  void dispatch(const KernelInfo& kernel, const void* args) override {
    const std::string variant = gl::variant_name(kernel, args);
    dispatched.insert(variant);
    if (!names_.count(variant)) names_[variant] = gl::expand_kernel(kernel, args, gl::shader_texts()).names;
    for (const Field& field : kernel.fields) {
      if (field.role < Role::table || !names_[variant].count(field.name)) continue;
      BufferStorage* buffer = nullptr;
      std::memcpy(static_cast<void*>(&buffer), static_cast<const char*>(args) + field.offset, sizeof(void*));
      if (buffer)
        used.insert(buffer->name());
      else
        missing.insert(variant + "." + field.name);
    }
    device_.dispatch(kernel, args);
  }
  void finish() override { device_.finish(); }
  void enter(std::string_view component) override { device_.enter(component); }
  void measure(bool on) override { device_.measure(on); }
  std::vector<Timing> take_timings() override { return device_.take_timings(); }
  std::size_t bytes_allocated() const override { return device_.bytes_allocated() - allocated_before_; }
  std::size_t bytes_peak() const override { return device_.bytes_peak(); }
  std::vector<std::string> kernels_prepared() const override { return device_.kernels_prepared(); }

  std::set<std::string> missing; ///< buffers that a shader names and nobody gave

private:
  Device& device_;
  std::size_t allocated_before_;
  std::map<std::string, std::set<std::string>> names_;
};

} // namespace pliant::test
