// OpenGL 4.3 contexts without a display, and the rules of living beside a host that has contexts of its own.
//
//   Context::open(i)          an own context: EGL device platform, else EGL surfaceless, else OSMesa
//   Context::from_current(f)  the host's, wrapped: never made current, never destroyed by us
//   Current                   makes a context current for a scope and puts the thread back as it was
//   HostState                 keeps a host's bindings over a scope, in a wrapped context
//
// The environment variable PLIANT_GL_CONTEXT = egl, surfaceless or osmesa forces one kind. Functions are held
// by context, since two implementations (libEGL's and libOSMesa's) may live in one process. A context may be
// used by one thread at a time.
#pragma once

#include "engine/device/device.h"

#include <memory>
#include <string>
#include <vector>

struct GladGLContext; // <glad/gl.h>

namespace pliant::gl {

/// A host's way to find GL functions, as GLFW's, SDL's and EGL's.
using GetProcAddress = void* (*)(const char* name);

class Context {
public:
  /// The device of describe_all() at `index`. Throws Error(no_device), naming what to install.
  static std::unique_ptr<Context> open(int index);
  /// A context in main memory. Throws Error(no_device) where libOSMesa is missing.
  static std::unique_ptr<Context> open_osmesa();
  /// The context that is current on this thread and belongs to the host, who keeps it current whenever Pliant
  /// is called and alive as long as this object. Throws Error(no_device) below OpenGL 4.3.
  static std::unique_ptr<Context> from_current(GetProcAddress get_proc_address);

  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
  virtual ~Context();

  /// Makes it current on this thread, whatever was. Nothing for a wrapped one. Throws Error(no_device).
  virtual void make_current() = 0;
  virtual bool is_current() const = 0;
  /// Belongs to the host.
  virtual bool wrapped() const { return false; }
  virtual void* get_proc_address(const char* name) const = 0;

  /// The functions of this context: `context.gl().BindBuffer(…)`. Valid while it is current.
  const GladGLContext& gl() const { return *functions_; }
  const std::string& kind() const { return kind_; } ///< "egl", "surfaceless", "osmesa" or "host"
  const std::string& vendor() const { return vendor_; }
  const std::string& renderer() const { return renderer_; }
  const std::string& version() const { return version_; }
  bool software() const; ///< a GL that runs on the CPU

protected:
  explicit Context(std::string kind);
  /// Loads the functions of the current context; false, with a reason, where it is older than OpenGL 4.3.
  bool load_functions(std::string& reason);

private:
  std::unique_ptr<GladGLContext> functions_;
  std::string kind_, vendor_, renderer_, version_;
};

/// What is current on a thread, of EGL and of OSMesa.
struct ThreadState {
  void *egl_display = nullptr, *egl_draw = nullptr, *egl_read = nullptr, *egl_context = nullptr;
  void *osmesa_context = nullptr, *osmesa_pixels = nullptr;
  int osmesa_width = 0, osmesa_height = 0;
  static ThreadState capture();
  bool empty() const { return !egl_context && !osmesa_context; }
  void unbind() const; ///< releases what this state names
  void bind() const;   ///< makes it current again
};

/// Makes a context current for a scope. The destructor restores what was current before; with
/// Restore::foreign only a context that is not one of ours, so that a loop of device calls does not switch at
/// each.
class Current {
public:
  enum class Restore { always, foreign };
  explicit Current(Context& context, Restore restore = Restore::always);
  ~Current();
  Current(const Current&) = delete;
  Current& operator=(const Current&) = delete;

private:
  ThreadState before_;
  bool switched_ = false;
};

/// Keeps the bindings that compute work touches (program, uniform and storage slots, copy buffers) over a
/// scope. Does nothing in a context of our own.
class HostState {
public:
  explicit HostState(const Context& context);
  ~HostState();
  HostState(const HostState&) = delete;
  HostState& operator=(const HostState&) = delete;

private:
  struct Slot {
    int buffer = 0;
    std::int64_t start = 0, size = 0;
  };
  const Context& context_;
  int program_ = 0, storage_ = 0, uniform_ = 0, copy_read_ = 0, copy_write_ = 0;
  std::vector<Slot> storage_slots_, uniform_slots_;
};

/// Every GL device of this machine, real GPUs first; one that cannot be used says what is missing.
std::vector<DeviceListing> describe_all();

} // namespace pliant::gl
