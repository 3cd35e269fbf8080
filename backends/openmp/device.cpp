// Runs kernels on the CPU: looks a body up by its declaration and calls it.
#include "backends/openmp/device.h"

#include "backends/openmp/table.h"
#include "engine/core/error.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <fstream>
#include <map>
#include <omp.h>
#include <set>
#include <unordered_map>
#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace pliant::openmp {

namespace {

using Clock = std::chrono::steady_clock;

class HostBuffer final : public BufferStorage {
public:
  HostBuffer(std::string_view name, Type type, std::size_t count, std::size_t bytes, std::size_t& allocated)
      : BufferStorage(name, type, count, bytes), allocated_(allocated) {
    // Whole cache lines, and one spare for wide loads that reach past the last element; whole huge pages
    // where there are many, as bonds are read from end to end and their neighbours jump from layer to layer.
    const std::size_t grain = bytes >= 4 * huge_page ? huge_page : alignment;
    const std::size_t padded = (bytes + alignment + grain - 1) / grain * grain;
    data_ = std::aligned_alloc(grain, padded);
    if (!data_)
      throw Error(ExitCode::too_large, "no memory for buffer '" + std::string(name) + "' of " +
                                           std::to_string(bytes) + " bytes; use a larger spacing");
#if defined(MADV_HUGEPAGE)
    if (grain == huge_page) madvise(data_, padded, MADV_HUGEPAGE); // a wish: nothing depends on it
#endif
    // Touched by the threads that will use it, so that pages lie near them.
    const std::size_t pages = (padded + page - 1) / page;
#pragma omp parallel for schedule(static)
    for (std::size_t p = 0; p < pages; ++p)
      std::memset(static_cast<char*>(data_) + p * page, 0, std::min(page, padded - p * page));
    allocated_ += bytes;
  }
  ~HostBuffer() override {
    allocated_ -= bytes();
    std::free(data_);
  }
  HostBuffer(const HostBuffer&) = delete;
  HostBuffer& operator=(const HostBuffer&) = delete;
  void* data() const {
    return data_;
  }

private:
  static constexpr std::size_t alignment = 64, page = 4096, huge_page = std::size_t{2} << 20;
  void* data_ = nullptr;
  std::size_t& allocated_;
};

char* memory(const BufferStorage* buffer) {
  return static_cast<char*>(static_cast<const HostBuffer*>(buffer)->data());
}

class HostReadback final : public Readback {
public:
  HostReadback(const char* from, std::size_t bytes)
      : values_(reinterpret_cast<const std::byte*>(from), reinterpret_cast<const std::byte*>(from) + bytes) {}
  bool ready() override { return true; }
  std::span<const std::byte> wait() override { return values_; }

private:
  std::vector<std::byte> values_;
};

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
  return "CPU";
}

class HostDevice final : public Device {
public:
  HostDevice(Precision precision, unsigned threads) {
    info_.backend = "openmp";
    info_.name = processor_name();
    info_.driver = std::string("OpenMP ") + std::to_string(_OPENMP) + ", " + instruction_set();
    info_.precision = precision;
    info_.threads = threads ? threads : static_cast<unsigned>(omp_get_num_procs());
  }

  const DeviceInfo& info() const override { return info_; }

  Buffer allocate(std::string_view name, Type type, std::size_t count) override {
    omp_set_num_threads(static_cast<int>(info_.threads));
    auto buffer = std::make_unique<HostBuffer>(name, type, count,
                                               count * element_bytes(type, info_.precision), allocated_);
    peak_ = std::max(peak_, allocated_);
    return Buffer(std::move(buffer));
  }

  void write(BufferStorage* buffer, std::size_t first, std::span<const std::byte> bytes) override {
    if (!bytes.empty()) std::memcpy(memory(buffer) + first, bytes.data(), bytes.size());
  }
  void read(const BufferStorage* buffer, std::size_t first, std::span<std::byte> bytes) override {
    if (!bytes.empty()) std::memcpy(bytes.data(), memory(buffer) + first, bytes.size());
  }
  void copy(const BufferStorage* from, BufferStorage* to) override {
    std::memcpy(memory(to), memory(from), std::min(from->bytes(), to->bytes()));
  }
  std::unique_ptr<Readback> request(const BufferStorage* buffer, std::size_t first,
                                    std::size_t bytes) override {
    return std::make_unique<HostReadback>(memory(buffer) + first, bytes);
  }

  void prepare(const KernelInfo& kernel, const void*) override { body(kernel); }

  void dispatch(const KernelInfo& kernel, const void* args) override {
    const Body loop = body(kernel);
    // Waking a team costs more than a small loop. One thread or all: another team size would end threads.
    const bool small = static_cast<const ArgsHeader*>(args)->threads < smallest_shared;
    omp_set_num_threads(small ? 1 : static_cast<int>(info_.threads));
    loop(args, [](const BufferStorage* buffer) -> void* { return buffer ? memory(buffer) : nullptr; });
  }

  void finish() override {}

  void enter(std::string_view component) override {
    if (!measuring_) return;
    const auto now = Clock::now();
    if (!component_.empty())
      spent_[component_] += std::chrono::duration<double, std::milli>(now - since_).count();
    component_ = component;
    since_ = now;
  }
  void measure(bool on) override {
    enter("");
    measuring_ = on;
  }
  std::vector<Timing> take_timings() override {
    enter("");
    std::vector<Timing> result;
    for (const auto& [component, milliseconds] : spent_) result.push_back({component, milliseconds});
    spent_.clear();
    return result;
  }

  std::size_t bytes_allocated() const override { return allocated_; }
  std::size_t bytes_peak() const override { return peak_; }
  std::vector<std::string> kernels_prepared() const override { return prepared_; }

private:
  static constexpr std::uint32_t smallest_shared = 512; ///< threads of a kernel: a few us of work

  Body body(const KernelInfo& kernel) {
    const auto known = bodies_.find(&kernel);
    if (known != bodies_.end()) return known->second;
    const Body found = find_body(kernel.name, info_.precision);
    if (!found)
      throw Error(ExitCode::internal,
                  std::string("kernel '") + kernel.name + "' has no body on the CPU backend");
    bodies_.emplace(&kernel, found);
    prepared_.emplace_back(kernel.name);
    return found;
  }

  DeviceInfo info_;
  std::size_t allocated_ = 0, peak_ = 0;
  std::unordered_map<const KernelInfo*, Body> bodies_;
  std::vector<std::string> prepared_;
  bool measuring_ = false;
  std::string component_;
  Clock::time_point since_;
  std::map<std::string, double> spent_;
};

} // namespace

std::unique_ptr<Device> make_device(Precision precision, unsigned threads) {
  return std::make_unique<HostDevice>(precision, threads);
}

DeviceListing describe() {
  return {"openmp",
          processor_name(),
          std::string("OpenMP ") + std::to_string(_OPENMP) + ", " + instruction_set(),
          0,
          false,
          true,
          ""};
}

} // namespace pliant::openmp
