// What every context shares, and the guards that leave a thread and a host as they were.
#include "backends/gl/context.h"

#include "backends/gl/context_kinds.h"
#include "backends/gl/egl.h"
#include "engine/core/error.h"

#include <glad/gl.h>

#include <algorithm>
#include <cctype>
#include <mutex>
#include <set>

namespace pliant::gl {

namespace {

// The native handles of our own contexts, to tell them from a host's.
std::mutex own_mutex;
std::set<void*>& own_contexts() {
  static std::set<void*> contexts;
  return contexts;
}

bool is_own(void* native) {
  const std::lock_guard lock(own_mutex);
  return own_contexts().count(native) > 0;
}

class HostContext final : public Context {
public:
  explicit HostContext(GetProcAddress get) : Context("host"), get_(get) {
    std::string reason;
    if (!load_functions(reason))
      throw Error(ExitCode::no_device, "the host's current context cannot be used: " + reason);
  }
  void make_current() override {}
  bool is_current() const override { return true; }
  bool wrapped() const override { return true; }
  void* get_proc_address(const char* name) const override { return get_(name); }

private:
  GetProcAddress get_;
};

} // namespace

void remember_own(void* native) {
  const std::lock_guard lock(own_mutex);
  own_contexts().insert(native);
}

void forget_own(void* native) {
  const std::lock_guard lock(own_mutex);
  own_contexts().erase(native);
}

bool software_renderer(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
  for (const char* word : {"llvmpipe", "softpipe", "swrast", "swr ", "software rasterizer", "swiftshader"})
    if (name.find(word) != std::string::npos) return true;
  return false;
}

Context::Context(std::string kind) : functions_(std::make_unique<GladGLContext>()), kind_(std::move(kind)) {}

Context::~Context() = default;

std::unique_ptr<Context> Context::from_current(GetProcAddress get_proc_address) {
  if (!get_proc_address) throw Error(ExitCode::no_device, "a host's context needs its function loader");
  return std::make_unique<HostContext>(get_proc_address);
}

bool Context::software() const {
  return software_renderer(renderer_);
}

bool Context::load_functions(std::string& reason) {
  const auto load = [](void* self, const char* name) {
    return reinterpret_cast<GLADapiproc>(static_cast<const Context*>(self)->get_proc_address(name));
  };
  const int version = gladLoadGLContextUserPtr(functions_.get(), load, this);
  const auto text = [&](GLenum name) {
    const GLubyte* value = functions_->GetString(name);
    return std::string(value ? reinterpret_cast<const char*>(value) : "");
  };
  if (version == 0) {
    reason = "no OpenGL context is current";
    return false;
  }
  vendor_ = text(GL_VENDOR);
  renderer_ = text(GL_RENDERER);
  version_ = text(GL_VERSION);
  if (version < GLAD_MAKE_VERSION(4, 3)) {
    reason = renderer_ + " has OpenGL " + version_ + ", and 4.3 is needed";
    return false;
  }
  return true;
}

ThreadState ThreadState::capture() {
  ThreadState state;
  if (const Egl* egl = Egl::load(); egl && (state.egl_context = egl->current_context())) {
    state.egl_display = egl->current_display();
    state.egl_draw = egl->current_surface(Egl::draw);
    state.egl_read = egl->current_surface(Egl::read);
  }
  if (const OsMesa* osmesa = OsMesa::loaded(); osmesa && (state.osmesa_context = osmesa->current_context())) {
    int format = 0;
    osmesa->color_buffer(state.osmesa_context, &state.osmesa_width, &state.osmesa_height, &format,
                         &state.osmesa_pixels);
  }
  return state;
}

// Released before another implementation is bound: both keep the current context of a thread to themselves.
void ThreadState::unbind() const {
  if (egl_context) Egl::load()->make_current(egl_display, nullptr, nullptr, nullptr);
  if (osmesa_context) OsMesa::load()->make_current(nullptr, nullptr, 0, 0, 0);
}

void ThreadState::bind() const {
  if (egl_context) Egl::load()->make_current(egl_display, egl_draw, egl_read, egl_context);
  if (osmesa_context)
    OsMesa::load()->make_current(osmesa_context, osmesa_pixels, OsMesa::unsigned_byte, osmesa_width,
                                 osmesa_height);
}

Current::Current(Context& context, Restore restore) {
  if (context.is_current()) return;
  before_ = ThreadState::capture();
  const bool foreign = (before_.egl_context && !is_own(before_.egl_context)) ||
                       (before_.osmesa_context && !is_own(before_.osmesa_context));
  context.make_current();
  switched_ = foreign || restore == Restore::always;
}

Current::~Current() {
  if (!switched_) return;
  ThreadState::capture().unbind();
  before_.bind();
}

namespace {
constexpr int storage_slot_count = 8, uniform_slot_count = 12;
}

HostState::HostState(const Context& context) : context_(context) {
  if (!context.wrapped()) return;
  const GladGLContext& gl = context.gl();
  gl.GetIntegerv(GL_CURRENT_PROGRAM, &program_);
  gl.GetIntegerv(GL_SHADER_STORAGE_BUFFER_BINDING, &storage_);
  gl.GetIntegerv(GL_UNIFORM_BUFFER_BINDING, &uniform_);
  gl.GetIntegerv(GL_COPY_READ_BUFFER_BINDING, &copy_read_);
  gl.GetIntegerv(GL_COPY_WRITE_BUFFER_BINDING, &copy_write_);
  const auto keep = [&](std::vector<Slot>& slots, int count, GLenum binding, GLenum start, GLenum size) {
    slots.resize(count);
    for (int i = 0; i < count; ++i) {
      Slot& slot = slots[i];
      gl.GetIntegeri_v(binding, i, &slot.buffer);
      gl.GetInteger64i_v(start, i, &slot.start);
      gl.GetInteger64i_v(size, i, &slot.size);
    }
  };
  keep(storage_slots_, storage_slot_count, GL_SHADER_STORAGE_BUFFER_BINDING, GL_SHADER_STORAGE_BUFFER_START,
       GL_SHADER_STORAGE_BUFFER_SIZE);
  keep(uniform_slots_, uniform_slot_count, GL_UNIFORM_BUFFER_BINDING, GL_UNIFORM_BUFFER_START,
       GL_UNIFORM_BUFFER_SIZE);
}

HostState::~HostState() {
  if (!context_.wrapped()) return;
  const GladGLContext& gl = context_.gl();
  const auto restore = [&](const std::vector<Slot>& slots, GLenum target) {
    for (GLuint i = 0; i < slots.size(); ++i) {
      const Slot& slot = slots[i];
      // A buffer bound as a whole reports a size of zero.
      if (slot.buffer && slot.size)
        gl.BindBufferRange(target, i, slot.buffer, static_cast<GLintptr>(slot.start),
                           static_cast<GLsizeiptr>(slot.size));
      else
        gl.BindBufferBase(target, i, slot.buffer);
    }
  };
  restore(storage_slots_, GL_SHADER_STORAGE_BUFFER);
  restore(uniform_slots_, GL_UNIFORM_BUFFER);
  gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, storage_);
  gl.BindBuffer(GL_UNIFORM_BUFFER, uniform_);
  gl.BindBuffer(GL_COPY_READ_BUFFER, copy_read_);
  gl.BindBuffer(GL_COPY_WRITE_BUFFER, copy_write_);
  gl.UseProgram(program_);
}

} // namespace pliant::gl
