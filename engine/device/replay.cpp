// Runs each kernel twice and compares.
#include "engine/device/replay.h"

#include "engine/core/error.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <sstream>
#include <string_view>

namespace pliant {

namespace {

bool is_buffer(const Field& field) {
  return field.role >= Role::table;
}
bool is_output(const Field& field) {
  return field.role == Role::out || field.role == Role::inout;
}

/// The kernel that leaves the order of what it writes to chance: it must be the same numbers. The kernel that
/// sorts them is compared place by place.
constexpr std::string_view in_any_order = "grid_place";

class ReplayDevice final : public Device {
public:
  ReplayDevice(std::unique_ptr<Device> device, std::unique_ptr<Device> reference)
      : device_(std::move(device)), reference_(std::move(reference)) {}

  Device& live() { return *device_; }

  const DeviceInfo& info() const override { return device_->info(); }
  Buffer allocate(std::string_view name, Type type, std::size_t count) override {
    return device_->allocate(name, type, count);
  }
  void write(BufferStorage* buffer, std::size_t first, std::span<const std::byte> bytes) override {
    device_->write(buffer, first, bytes);
  }
  void read(const BufferStorage* buffer, std::size_t first, std::span<std::byte> bytes) override {
    device_->read(buffer, first, bytes);
  }
  void copy(const BufferStorage* from, BufferStorage* to) override { device_->copy(from, to); }
  std::unique_ptr<Readback> request(const BufferStorage* buffer, std::size_t first,
                                    std::size_t bytes) override {
    return device_->request(buffer, first, bytes);
  }
  void prepare(const KernelInfo& kernel, const void* args) override {
    device_->prepare(kernel, args);
    reference_->prepare(kernel, args);
  }

  void dispatch(const KernelInfo& kernel, const void* args) override {
    ++dispatches_;
    // Args is a plain structure: its copy differs in the buffers alone. Held in doubles for their alignment.
    const std::size_t bytes = args_bytes(kernel);
    std::vector<double> twin_args(bytes / 8 + 1);
    std::memcpy(twin_args.data(), args, bytes);
    for (const Field& field : kernel.fields) {
      if (!is_buffer(field)) continue;
      BufferStorage* const buffer = argument(field, args);
      BufferStorage* const twin = buffer ? twin_of(buffer) : nullptr;
      if (buffer) copy_across(*device_, buffer, *reference_, twin);
      if (buffer && is_output(field)) reference_->copy(twin, twin_of(buffer, before_));
      std::memcpy(reinterpret_cast<char*>(twin_args.data()) + field.offset, &twin, sizeof(void*));
    }
    device_->dispatch(kernel, args);
    reference_->dispatch(kernel, twin_args.data());
    std::vector<Mismatch> mismatches;
    for (const Field& field : kernel.fields)
      if (is_output(field) && argument(field, args))
        compare(kernel, field, argument(field, args), mismatches);
    if (mismatches.empty()) return;
    const std::vector<Mismatch> left = without_ties(kernel, args, twin_args.data(), mismatches);
    if (!left.empty()) fail(kernel, left.front());
    ties_ += mismatches.size();
  }

  std::size_t ties() const { return ties_; }

  void finish() override { device_->finish(); }
  void enter(std::string_view component) override { device_->enter(component); }
  void measure(bool on) override { device_->measure(on); }
  std::vector<Timing> take_timings() override { return device_->take_timings(); }
  std::size_t bytes_allocated() const override { return device_->bytes_allocated(); }
  std::size_t bytes_peak() const override { return device_->bytes_peak(); }
  std::vector<std::string> kernels_prepared() const override { return device_->kernels_prepared(); }

private:
  struct Mismatch {
    const Field* field;
    const BufferStorage* buffer;
    std::size_t at; ///< number in the buffer, of four in a group
    double ours, theirs, allowed;
    bool ordered; ///< else `at` says nothing
  };

  static bool same(double a, double b, double allowed) {
    return a == b || (std::isnan(a) && std::isnan(b)) || std::abs(a - b) <= allowed;
  }
  static BufferStorage* argument(const Field& field, const void* args) {
    BufferStorage* buffer = nullptr;
    std::memcpy(&buffer, static_cast<const char*>(args) + field.offset, sizeof(void*));
    return buffer;
  }

  static std::size_t args_bytes(const KernelInfo& kernel) {
    std::size_t end = sizeof(ArgsHeader);
    for (const Field& field : kernel.fields) {
      const bool small =
          field.role == Role::option || (field.role == Role::parameter && field.type == Type::uint);
      end = std::max<std::size_t>(end, field.offset + (small ? 4 : 8));
    }
    return end;
  }

  BufferStorage* twin_of(const BufferStorage* buffer) { return twin_of(buffer, twins_); }
  BufferStorage* twin_of(const BufferStorage* buffer, std::map<const BufferStorage*, Buffer>& twins) {
    Buffer& twin = twins[buffer];
    if (!twin || twin->type() != buffer->type() || twin->count() != buffer->count())
      twin = reference_->allocate(buffer->name(), buffer->type(), buffer->count());
    return twin;
  }

  static void copy_across(Device& from, const BufferStorage* source, Device& to, BufferStorage* target) {
    if (source->bytes() == target->bytes()) {
      std::vector<std::byte> bytes(source->bytes());
      from.read(source, 0, bytes);
      to.write(target, 0, bytes);
    } else if (source->type() == Type::real) {
      to.upload(target, from.download_real(source));
    } else {
      to.upload(target, from.download_real4(source));
    }
  }

  // The values of a buffer as doubles, exact for both kinds of integers too.
  static std::vector<double> values(Device& device, const BufferStorage* buffer) {
    if (buffer->type() == Type::real) return device.download_real(buffer);
    if (buffer->type() == Type::real4) {
      const auto groups = device.download_real4(buffer);
      const auto* first = reinterpret_cast<const double*>(groups.data());
      return {first, first + 4 * groups.size()};
    }
    std::vector<std::uint32_t> whole(buffer->bytes() / 4);
    device.read(buffer, 0, std::as_writable_bytes(std::span(whole)));
    return {whole.begin(), whole.end()};
  }

  static void set_values(Device& device, BufferStorage* buffer, const std::vector<double>& numbers) {
    if (buffer->type() == Type::real) return device.upload(buffer, numbers);
    std::vector<Real4<double>> groups(numbers.size() / 4);
    std::memcpy(groups.data(), numbers.data(), numbers.size() * sizeof(double));
    device.upload(buffer, groups);
  }
  static bool is_real(const BufferStorage* buffer) {
    return buffer->type() == Type::real || buffer->type() == Type::real4;
  }

  void compare(const KernelInfo& kernel, const Field& field, const BufferStorage* buffer,
               std::vector<Mismatch>& mismatches) {
    std::vector<double> ours = values(*device_, buffer), theirs = values(*reference_, twin_of(buffer));
    const bool ordered = kernel.name != in_any_order || field.role != Role::out;
    if (!ordered) {
      std::sort(ours.begin(), ours.end());
      std::sort(theirs.begin(), theirs.end());
    }
    double largest = 0;
    for (const double value : theirs)
      if (std::isfinite(value)) largest = std::max(largest, std::abs(value));
    const double allowed = is_real(buffer) ? replay_tolerance * largest : 0;
    for (std::size_t i = 0; i < ours.size(); ++i)
      if (!same(ours[i], theirs[i], allowed))
        mismatches.push_back({&field, buffer, i, ours[i], theirs[i], allowed, ordered});
  }

  /// Those that the reference never gives, whichever input is off by a rounding.
  std::vector<Mismatch> without_ties(const KernelInfo& kernel, const void* args, const void* twin_args,
                                     std::vector<Mismatch> left) {
    for (const Field& field : kernel.fields) {
      BufferStorage* const buffer = is_buffer(field) ? argument(field, args) : nullptr;
      if (!buffer || field.role == Role::out || !is_real(buffer)) continue;
      BufferStorage* const twin = twin_of(buffer);
      const std::vector<double> exact =
          values(*reference_, is_output(field) ? twin_of(buffer, before_) : twin);
      for (const double sign : {1., -1.}) {
        for (const Field& written : kernel.fields)
          if (is_output(written) && argument(written, args))
            reference_->copy(twin_of(argument(written, args), before_), twin_of(argument(written, args)));
        std::vector<double> off = exact;
        for (double& number : off)
          if (number != std::floor(number))
            number *= 1 + sign * replay_rounding; // whole ones are counts and flags
        set_values(*reference_, twin, off);
        reference_->dispatch(kernel, twin_args);
        std::map<const BufferStorage*, std::vector<double>> results;
        for (const Mismatch& one : left)
          if (!results.contains(one.buffer)) results[one.buffer] = values(*reference_, twin_of(one.buffer));
        std::erase_if(left, [&](const Mismatch& one) {
          return one.ordered && same(one.ours, results[one.buffer][one.at], one.allowed);
        });
        if (left.empty()) return left;
      }
      set_values(*reference_, twin, exact);
    }
    return left;
  }

  [[noreturn]] void fail(const KernelInfo& kernel, const Mismatch& one) const {
    const std::size_t width = one.buffer->type() == Type::real4 || one.buffer->type() == Type::uint4 ? 4 : 1;
    std::ostringstream text;
    text.precision(9);
    text << "replay: dispatch " << dispatches_ << ", kernel '" << kernel.name << "', buffer '"
         << one.field->name << "', element " << one.at / width;
    if (width == 4)
      text << "."
           << "xyzw"[one.at % 4];
    text << ": " << one.ours << " on " << device_->info().backend << ", " << one.theirs << " on "
         << reference_->info().backend << " (" << reference_->info().name << "); allowed difference "
         << one.allowed;
    throw Error(ExitCode::internal, text.str());
  }

  std::unique_ptr<Device> device_, reference_;
  std::map<const BufferStorage*, Buffer> twins_;
  std::map<const BufferStorage*, Buffer> before_; ///< what twins held that a kernel then wrote to
  std::size_t dispatches_ = 0, ties_ = 0;
};

} // namespace

std::unique_ptr<Device> make_replay_device(std::unique_ptr<Device> device,
                                           std::unique_ptr<Device> reference) {
  return std::make_unique<ReplayDevice>(std::move(device), std::move(reference));
}

std::size_t replay_ties(const Device& device) {
  const auto* replay = dynamic_cast<const ReplayDevice*>(&device);
  return replay ? replay->ties() : 0;
}

Device& unwrapped(Device& device) {
  auto* replay = dynamic_cast<ReplayDevice*>(&device);
  return replay ? replay->live() : device;
}

} // namespace pliant
