// Buffers, transfers and dispatches by OpenGL.
#include "backends/gl/gl_device.h"

#include "backends/gl/parameter_ring.h"
#include "backends/gl/program.h"
#include "backends/gl/shader_text.h"
#include "backends/gl/timer.h"
#include "engine/core/error.h"
#include "engine/device/replay.h"

#include <glad/gl.h>

#include <algorithm>
#include <cstring>
#include <unordered_map>

namespace pliant::gl {

namespace {

// What buffers and readbacks share with their device, and may outlive it with.
struct State {
  explicit State(std::unique_ptr<Context> own) : context(std::move(own)) {}
  std::unique_ptr<Context> context;
  std::size_t allocated = 0, peak = 0;
  const GladGLContext& gl() const { return context->gl(); }
};

// The context is current and a host's bindings are kept, for a scope.
struct Scope {
  explicit Scope(const State& state) : current(*state.context, Current::Restore::foreign), host(*state.context) {}
  Current current;
  HostState host;
};

const char* error_name(GLenum error) {
  switch (error) {
  case GL_INVALID_ENUM: return "GL_INVALID_ENUM";
  case GL_INVALID_VALUE: return "GL_INVALID_VALUE";
  case GL_INVALID_OPERATION: return "GL_INVALID_OPERATION";
  case GL_INVALID_FRAMEBUFFER_OPERATION: return "GL_INVALID_FRAMEBUFFER_OPERATION";
  case GL_OUT_OF_MEMORY: return "GL_OUT_OF_MEMORY";
  default: return "an unknown error";
  }
}

class GlBuffer final : public BufferStorage {
public:
  GlBuffer(std::shared_ptr<State> state, std::string_view name, Type type, std::size_t count, std::size_t bytes)
      : BufferStorage(name, type, count, bytes), state_(std::move(state)) {
    const Scope scope(*state_);
    const GladGLContext& gl = state_->gl();
    while (gl.GetError() != GL_NO_ERROR) {
    }
    const auto size = static_cast<GLsizeiptr>(std::max<std::size_t>(bytes, 16)); // never of no size at all
    gl.GenBuffers(1, &name_);
    gl.BindBuffer(GL_COPY_WRITE_BUFFER, name_);
    gl.BufferData(GL_COPY_WRITE_BUFFER, size, nullptr, GL_DYNAMIC_COPY);
    GLenum error = gl.GetError();
    if (error == GL_NO_ERROR) {
      gl.ClearBufferData(GL_COPY_WRITE_BUFFER, GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, nullptr);
      error = gl.GetError();
    }
    if (error != GL_NO_ERROR) {
      gl.DeleteBuffers(1, &name_);
      throw Error(error == GL_OUT_OF_MEMORY ? ExitCode::too_large : ExitCode::internal,
                  "no memory on " + state_->context->renderer() + " for buffer '" + std::string(name) + "' of " +
                      std::to_string(bytes) + " bytes beside " + std::to_string(state_->allocated) +
                      " in use (" + error_name(error) + "); use a larger spacing");
    }
    state_->allocated += bytes;
    state_->peak = std::max(state_->peak, state_->allocated);
  }
  ~GlBuffer() override {
    state_->allocated -= bytes();
    try {
      const Current current(*state_->context, Current::Restore::foreign);
      state_->gl().DeleteBuffers(1, &name_);
    } catch (const Error&) {
      // In use by another thread: the driver frees it with the context.
    }
  }
  unsigned gl() const { return name_; }

private:
  std::shared_ptr<State> state_;
  GLuint name_ = 0;
};

GLuint name_of(const BufferStorage* buffer) { return static_cast<const GlBuffer*>(buffer)->gl(); }

class GlReadback final : public Readback {
public:
  GlReadback(std::shared_ptr<State> state, GLuint from, std::size_t first, std::size_t bytes)
      : state_(std::move(state)), values_(bytes) {
    const GladGLContext& gl = state_->gl();
    gl.GenBuffers(1, &staging_);
    gl.BindBuffer(GL_COPY_READ_BUFFER, from);
    gl.BindBuffer(GL_COPY_WRITE_BUFFER, staging_);
    gl.BufferData(GL_COPY_WRITE_BUFFER, static_cast<GLsizeiptr>(std::max<std::size_t>(bytes, 16)), nullptr,
                  GL_STREAM_READ);
    gl.CopyBufferSubData(GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, static_cast<GLintptr>(first), 0,
                         static_cast<GLsizeiptr>(bytes));
    fence_ = gl.FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.Flush();
  }
  ~GlReadback() override {
    if (!staging_) return;
    try {
      const Scope scope(*state_);
      drop();
    } catch (const Error&) {
      // In use by another thread: the driver frees both with the context.
    }
  }

  bool ready() override {
    if (!staging_) return true;
    const Scope scope(*state_);
    return state_->gl().ClientWaitSync(fence_, 0, 0) != GL_TIMEOUT_EXPIRED;
  }

  std::span<const std::byte> wait() override {
    if (!staging_) return values_;
    const Scope scope(*state_);
    const GladGLContext& gl = state_->gl();
    GLenum state = GL_TIMEOUT_EXPIRED;
    while (state == GL_TIMEOUT_EXPIRED)
      state = gl.ClientWaitSync(fence_, GL_SYNC_FLUSH_COMMANDS_BIT, 1'000'000'000);
    if (state == GL_WAIT_FAILED) throw Error(ExitCode::internal, "the GL device was lost while reading back");
    gl.BindBuffer(GL_COPY_READ_BUFFER, staging_);
    gl.GetBufferSubData(GL_COPY_READ_BUFFER, 0, static_cast<GLsizeiptr>(values_.size()), values_.data());
    drop();
    return values_;
  }

private:
  void drop() {
    state_->gl().DeleteSync(fence_);
    state_->gl().DeleteBuffers(1, &staging_);
    staging_ = 0;
  }

  std::shared_ptr<State> state_;
  std::vector<std::byte> values_;
  GLuint staging_ = 0;
  GLsync fence_ = nullptr;
};

// Every dispatch is spread over rows of at most this many groups: what OpenGL promises a dimension.
constexpr std::uint32_t max_groups = 65535;

template <class Value> Value argument(const void* args, std::uint32_t offset) {
  Value value{};
  std::memcpy(&value, static_cast<const char*>(args) + offset, sizeof value);
  return value;
}

class GlDevice final : public Device {
public:
  GlDevice(std::unique_ptr<Context> context, const Texts& texts)
      : state_(std::make_shared<State>(std::move(context))), texts_(texts) {
    const Scope scope(*state_);
    const Context& used = *state_->context;
    info_.backend = "gl";
    info_.name = used.renderer();
    info_.driver = "OpenGL " + used.version() + ", " + used.vendor() + ", " + used.kind();
    info_.software = used.software();
    GLint64 limit = 0;
    state_->gl().GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &limit);
    info_.max_buffer_bytes = static_cast<std::size_t>(limit);
    ring_ = std::make_unique<ParameterRing>(used);
    timer_ = std::make_unique<Timer>(used);
  }

  ~GlDevice() override {
    try {
      const Scope scope(*state_);
      variants_.clear();
      timer_->release();
      ring_->release();
    } catch (const Error&) {
      // In use by another thread: the driver frees it all with the context.
    }
  }

  const DeviceInfo& info() const override { return info_; }
  State& state() { return *state_; }
  unsigned from_cache() const { return from_cache_; }

  Buffer allocate(std::string_view name, Type type, std::size_t count) override {
    const std::size_t each = element_bytes(type, Precision::single_precision);
    if (count > info_.max_buffer_bytes / each)
      throw Error(ExitCode::too_large, "buffer '" + std::string(name) + "' needs " + std::to_string(count) + " x " +
                                           std::to_string(each) + " bytes, more than the " +
                                           std::to_string(info_.max_buffer_bytes) +
                                           " bytes of GL_MAX_SHADER_STORAGE_BLOCK_SIZE on " + info_.name +
                                           "; use a larger spacing or --backend openmp");
    return Buffer(std::make_unique<GlBuffer>(state_, name, type, count, count * each));
  }

  void write(BufferStorage* buffer, std::size_t first, std::span<const std::byte> bytes) override {
    if (bytes.empty()) return;
    const Scope scope(*state_);
    const GladGLContext& gl = state_->gl();
    gl.BindBuffer(GL_COPY_WRITE_BUFFER, name_of(buffer));
    gl.BufferSubData(GL_COPY_WRITE_BUFFER, static_cast<GLintptr>(first), static_cast<GLsizeiptr>(bytes.size()),
                     bytes.data());
  }

  void read(const BufferStorage* buffer, std::size_t first, std::span<std::byte> bytes) override {
    if (bytes.empty()) return;
    const Scope scope(*state_);
    const GladGLContext& gl = state_->gl();
    gl.BindBuffer(GL_COPY_READ_BUFFER, name_of(buffer));
    gl.GetBufferSubData(GL_COPY_READ_BUFFER, static_cast<GLintptr>(first), static_cast<GLsizeiptr>(bytes.size()),
                        bytes.data());
    check("a read of buffer '" + buffer->name() + "'");
  }

  void copy(const BufferStorage* from, BufferStorage* to) override {
    const std::size_t bytes = std::min(from->bytes(), to->bytes());
    if (bytes == 0 || from == to) return;
    const Scope scope(*state_);
    const GladGLContext& gl = state_->gl();
    gl.BindBuffer(GL_COPY_READ_BUFFER, name_of(from));
    gl.BindBuffer(GL_COPY_WRITE_BUFFER, name_of(to));
    gl.CopyBufferSubData(GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, 0, 0, static_cast<GLsizeiptr>(bytes));
  }

  std::unique_ptr<Readback> request(const BufferStorage* buffer, std::size_t first, std::size_t bytes) override {
    if (first + bytes > buffer->bytes())
      throw Error(ExitCode::internal, "a readback reaches beyond buffer '" + buffer->name() + "'");
    const Scope scope(*state_);
    return std::make_unique<GlReadback>(state_, name_of(buffer), first, bytes);
  }

  void prepare(const KernelInfo& kernel, const void* args) override {
    const Scope scope(*state_);
    variant(kernel, args);
  }

  void dispatch(const KernelInfo& kernel, const void* args) override {
    const Scope scope(*state_);
    const KernelProgram& program = variant(kernel, args);
    const std::uint32_t threads = argument<ArgsHeader>(args, 0).threads;
    if (threads == 0) return;
    const GladGLContext& gl = state_->gl();
    bind(kernel, args, program);
    gl.UseProgram(program.program.name());
    const std::uint32_t groups = (threads - 1) / kernel.group_size + 1;
    const std::uint32_t rows = (groups - 1) / max_groups + 1;
    gl.DispatchCompute((groups - 1) / rows + 1, rows, 1);
    gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_UNIFORM_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
  }

  void finish() override {
    const Scope scope(*state_);
    state_->gl().MemoryBarrier(GL_ALL_BARRIER_BITS);
    state_->gl().Finish();
    check("the work before finish()");
  }

  void enter(std::string_view component) override {
    if (!timer_->measuring()) return;
    const Scope scope(*state_);
    timer_->enter(component);
  }
  void measure(bool on) override {
    const Scope scope(*state_);
    timer_->measure(on);
  }
  std::vector<Timing> take_timings() override {
    const Scope scope(*state_);
    return timer_->take();
  }

  std::size_t bytes_allocated() const override { return state_->allocated; }
  std::size_t bytes_peak() const override { return state_->peak; }
  std::vector<std::string> kernels_prepared() const override { return prepared_; }

private:
  struct Variant {
    std::vector<std::uint32_t> options;
    std::unique_ptr<KernelProgram> program;
  };

  void check(const std::string& what) const {
    const GLenum error = state_->gl().GetError();
    if (error != GL_NO_ERROR)
      throw Error(error == GL_OUT_OF_MEMORY ? ExitCode::too_large : ExitCode::internal,
                  "OpenGL reports " + std::string(error_name(error)) + " at " + what);
  }

  const KernelProgram& variant(const KernelInfo& kernel, const void* args) {
    std::vector<Variant>& known = variants_[&kernel];
    for (const Variant& one : known) {
      auto value = one.options.begin();
      if (std::all_of(kernel.fields.begin(), kernel.fields.end(), [&](const Field& field) {
            return field.role != Role::option || *value++ == argument<std::uint32_t>(args, field.offset);
          }))
        return *one.program;
    }
    Variant fresh;
    for (const Field& field : kernel.fields)
      if (field.role == Role::option) fresh.options.push_back(argument<std::uint32_t>(args, field.offset));
    fresh.program = std::make_unique<KernelProgram>(*state_->context, kernel, args, texts_);
    from_cache_ += fresh.program->program.from_cache();
    prepared_.push_back(variant_name(kernel, args));
    known.push_back(std::move(fresh));
    return *known.back().program;
  }

  void bind(const KernelInfo& kernel, const void* args, const KernelProgram& program) {
    const GladGLContext& gl = state_->gl();
    parameters_.assign(1, argument<ArgsHeader>(args, 0).threads);
    const auto fail = [&](const Field& field, const char* what) {
      throw Error(ExitCode::internal, std::string("kernel '") + kernel.name + "': buffer '" + field.name + "' " + what);
    };
    for (const Field& field : kernel.fields) {
      if (field.role == Role::option) continue;
      if (field.role == Role::parameter) {
        std::uint32_t bits = 0;
        if (field.type == Type::real) {
          const auto value = static_cast<float>(argument<double>(args, field.offset));
          std::memcpy(&bits, &value, sizeof bits);
        } else {
          bits = argument<std::uint32_t>(args, field.offset);
        }
        parameters_.push_back(bits);
        continue;
      }
      const BufferStorage* buffer = argument<BufferStorage*>(args, field.offset);
      if (field.role == Role::table) {
        const std::size_t needed = program.table_bytes[field.slot];
        if (needed == 0) continue;
        if (!buffer) fail(field, "is used by this variant and not given");
        if (buffer->bytes() < needed) fail(field, "is smaller than its table");
        gl.BindBufferBase(GL_UNIFORM_BUFFER, field.slot, name_of(buffer));
        continue;
      }
      if (!program.uses_slot[field.slot]) continue;
      if (!buffer) fail(field, "is used by this variant and not given");
      gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, field.slot, name_of(buffer));
    }
    ring_->bind(parameter_slot, parameters_.data(), 4 * parameters_.size());
  }

  std::shared_ptr<State> state_;
  const Texts& texts_;
  DeviceInfo info_;
  std::unique_ptr<ParameterRing> ring_;
  std::unique_ptr<Timer> timer_;
  std::unordered_map<const KernelInfo*, std::vector<Variant>> variants_;
  std::vector<std::string> prepared_;
  std::vector<std::uint32_t> parameters_; ///< of the dispatch under way
  unsigned from_cache_ = 0;
};

GlDevice& gl_device(Device& device) {
  auto* found = dynamic_cast<GlDevice*>(&unwrapped(device));
  if (!found) throw Error(ExitCode::internal, "a GL device was expected, and this one is " + device.info().backend);
  return *found;
}

} // namespace

std::unique_ptr<Device> make_device(std::unique_ptr<Context> context, const Texts* texts) {
  return std::make_unique<GlDevice>(std::move(context), texts ? *texts : shader_texts());
}

std::unique_ptr<Device> make_device(int index) { return make_device(Context::open(index)); }

bool is_gl(Device& device) { return dynamic_cast<GlDevice*>(&unwrapped(device)) != nullptr; }

Context& context_of(Device& device) { return *gl_device(device).state().context; }

unsigned gl_name(const BufferStorage& buffer) {
  const auto* found = dynamic_cast<const GlBuffer*>(&buffer);
  if (!found) throw Error(ExitCode::internal, "buffer '" + buffer.name() + "' is not on a GL device");
  return found->gl();
}

unsigned programs_from_cache(Device& device) { return gl_device(device).from_cache(); }

} // namespace pliant::gl
