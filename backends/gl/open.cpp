// Finds the GL devices of a machine without a display and opens contexts on them.
#include "backends/gl/context.h"

#include "backends/gl/context_kinds.h"
#include "backends/gl/egl.h"
#include "engine/core/error.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <mutex>

namespace pliant::gl {

namespace {

constexpr const char* advice =
    "install libegl1 and libgl1-mesa-dri (Debian), or the EGL library of the GPU's maker";

class EglContext final : public Context {
public:
  EglContext(void* display, const char* kind) : Context(kind), egl_(*Egl::load()), display_(display) {
    const ThreadState before = ThreadState::capture();
    const unsigned api = egl_.query_api();
    egl_.bind_api(Egl::opengl_api);
    std::string reason = create();
    egl_.bind_api(api);
    if (reason.empty()) {
      remember_own(context_);
      make_current();
      const bool good = load_functions(reason);
      egl_.make_current(display_, nullptr, nullptr, nullptr);
      before.bind();
      if (good) return;
    }
    destroy();
    throw Error(ExitCode::no_device, reason);
  }
  ~EglContext() override {
    if (is_current()) egl_.make_current(display_, nullptr, nullptr, nullptr);
    destroy();
  }

  void make_current() override {
    if (is_current()) return;
    ThreadState::capture().unbind();
    if (!egl_.make_current(display_, surface_, surface_, context_))
      throw Error(ExitCode::no_device, "the EGL context cannot be made current here (" + error() +
                                           "); it may be in use by another thread, or this thread may have a "
                                           "context that is not EGL's: hand that one over instead");
  }
  bool is_current() const override { return context_ && egl_.current_context() == context_; }
  void* get_proc_address(const char* name) const override { return egl_.get_proc_address(name); }

private:
  std::string error() const {
    char text[32];
    std::snprintf(text, sizeof text, "EGL error 0x%x", static_cast<unsigned>(egl_.get_error()));
    return text;
  }

  // Returns what went wrong, or nothing.
  std::string create() {
    const char* extensions = egl_.query_string(display_, Egl::extensions);
    const bool surfaceless = has_extension(extensions, "EGL_KHR_surfaceless_context");
    void* config = nullptr;
    if (!surfaceless || !has_extension(extensions, "EGL_KHR_no_config_context")) {
      const Egl::Int wanted[] = {Egl::surface_type, surfaceless ? 0 : Egl::pbuffer_bit, Egl::renderable_type,
                                 Egl::opengl_bit, Egl::none};
      Egl::Int count = 0;
      if (!egl_.choose_config(display_, wanted, &config, 1, &count) || count < 1)
        return "EGL has no configuration for OpenGL";
    }
    const Egl::Int attributes[] = {Egl::context_major,    4,        Egl::context_minor, 3, Egl::profile_mask,
                                   Egl::core_profile_bit, Egl::none};
    context_ = egl_.create_context(display_, config, nullptr, attributes);
    if (!context_) return "the driver gives no OpenGL 4.3 core context (" + error() + ")";
    if (!surfaceless) {
      const Egl::Int size[] = {Egl::width, 16, Egl::height, 16, Egl::none};
      surface_ = egl_.create_pbuffer(display_, config, size);
      if (!surface_) return "EGL gives neither a surfaceless context nor a pbuffer (" + error() + ")";
    }
    return {};
  }

  void destroy() {
    if (surface_) egl_.destroy_surface(display_, surface_);
    if (context_) {
      forget_own(context_);
      egl_.destroy_context(display_, context_);
    }
    context_ = surface_ = nullptr;
  }

  const Egl& egl_;
  void *display_, *context_ = nullptr, *surface_ = nullptr;
};

class OsMesaContext final : public Context {
public:
  OsMesaContext() : Context("osmesa"), osmesa_(required()) {
    const ThreadState before = ThreadState::capture();
    const int attributes[] = {OsMesa::format,
                              OsMesa::rgba,
                              OsMesa::profile,
                              OsMesa::core_profile,
                              OsMesa::context_major,
                              4,
                              OsMesa::context_minor,
                              3,
                              0,
                              0};
    context_ = osmesa_.create_context(attributes, nullptr);
    if (!context_) throw Error(ExitCode::no_device, "libOSMesa gives no OpenGL 4.3 core context");
    remember_own(context_);
    make_current();
    std::string reason;
    const bool good = load_functions(reason);
    osmesa_.make_current(nullptr, nullptr, 0, 0, 0);
    before.bind();
    if (good) return;
    destroy();
    throw Error(ExitCode::no_device, reason);
  }
  ~OsMesaContext() override {
    if (is_current()) osmesa_.make_current(nullptr, nullptr, 0, 0, 0);
    destroy();
  }

  void make_current() override {
    if (is_current()) return;
    ThreadState::capture().unbind();
    if (!osmesa_.make_current(context_, pixels_, OsMesa::unsigned_byte, side, side))
      throw Error(ExitCode::no_device, "the OSMesa context cannot be made current on this thread");
  }
  bool is_current() const override { return osmesa_.current_context() == context_; }
  void* get_proc_address(const char* name) const override { return osmesa_.get_proc_address(name); }

private:
  static const OsMesa& required() {
    const OsMesa* osmesa = OsMesa::load();
    if (!osmesa) throw Error(ExitCode::no_device, "libOSMesa is not here; install libosmesa6 (Debian)");
    return *osmesa;
  }
  void destroy() {
    forget_own(context_);
    osmesa_.destroy_context(context_);
  }

  static constexpr int side = 16; // pixels of a surface that nothing draws to
  const OsMesa& osmesa_;
  void* context_ = nullptr;
  unsigned char pixels_[4 * side * side] = {};
};

// One way to a device. Displays live as long as the process: a host may share them.
struct Candidate {
  DeviceListing listing;
  std::string kind;
  void* display = nullptr;
};

Candidate examine(const std::string& kind, void* display) {
  Candidate candidate;
  candidate.kind = kind;
  candidate.display = display;
  candidate.listing.backend = "gl";
  try {
    std::unique_ptr<Context> context;
    if (kind == "osmesa")
      context = Context::open_osmesa();
    else
      context = std::make_unique<EglContext>(display, kind.c_str());
    candidate.listing.name = context->renderer();
    candidate.listing.driver = "OpenGL " + context->version() + ", " + context->vendor() + ", " + kind;
    candidate.listing.software = context->software();
    candidate.listing.usable = true;
  } catch (const Error& error) {
    candidate.listing.name = kind;
    candidate.listing.missing = error.what();
  }
  return candidate;
}

void add_display(std::vector<Candidate>& candidates, const char* kind, unsigned platform, void* native) {
  const Egl& egl = *Egl::load();
  void* display = egl.get_platform_display(platform, native, nullptr);
  Egl::Int major = 0, minor = 0;
  if (display && egl.initialize(display, &major, &minor)) candidates.push_back(examine(kind, display));
}

bool any_usable(const std::vector<Candidate>& candidates) {
  return std::any_of(candidates.begin(), candidates.end(),
                     [](const Candidate& c) { return c.listing.usable; });
}

std::vector<Candidate> find_candidates(const std::string& forced) {
  std::vector<Candidate> candidates;
  const Egl* egl = forced == "osmesa" ? nullptr : Egl::load();
  if (egl && egl->get_platform_display) {
    const char* client = egl->query_string(nullptr, Egl::extensions);
    if (forced != "surfaceless" && egl->query_devices && has_extension(client, "EGL_EXT_platform_device")) {
      Egl::Int count = 0;
      std::vector<void*> devices;
      if (egl->query_devices(0, nullptr, &count) && count > 0) devices.resize(count);
      if (count > 0 && egl->query_devices(count, devices.data(), &count))
        for (void* device : devices) add_display(candidates, "egl", Egl::platform_device, device);
    }
    if (forced != "egl" && !any_usable(candidates) && has_extension(client, "EGL_MESA_platform_surfaceless"))
      add_display(candidates, "surfaceless", Egl::platform_surfaceless, nullptr);
  }
  if (forced == "osmesa" || (forced.empty() && !any_usable(candidates) && OsMesa::load()))
    candidates.push_back(examine("osmesa", nullptr));
  const auto rank = [](const Candidate& c) { return !c.listing.usable ? 2 : c.listing.software ? 1 : 0; };
  std::stable_sort(candidates.begin(), candidates.end(),
                   [&](const Candidate& a, const Candidate& b) { return rank(a) < rank(b); });
  int index = 0;
  for (Candidate& candidate : candidates) candidate.listing.index = index++;
  return candidates;
}

// Looking is slow (a context for each device), so it is done once for each way of looking.
const std::vector<Candidate>& candidates() {
  const char* environment = std::getenv("PLIANT_GL_CONTEXT");
  const std::string forced = environment ? environment : "";
  if (!forced.empty() && forced != "egl" && forced != "surfaceless" && forced != "osmesa")
    throw Error(ExitCode::usage,
                "PLIANT_GL_CONTEXT is '" + forced + "'; it may be egl, surfaceless or osmesa");
  static std::mutex mutex;
  static std::map<std::string, std::vector<Candidate>> found;
  const std::lock_guard lock(mutex);
  const auto known = found.find(forced);
  if (known != found.end()) return known->second;
  return found.emplace(forced, find_candidates(forced)).first->second;
}

} // namespace

std::unique_ptr<Context> Context::open_osmesa() {
  return std::make_unique<OsMesaContext>();
}

std::unique_ptr<Context> Context::open(int index) {
  const std::vector<Candidate>& all = candidates();
  const auto usable =
      std::count_if(all.begin(), all.end(), [](const Candidate& c) { return c.listing.usable; });
  if (usable == 0) {
    std::string reasons;
    for (const Candidate& c : all) reasons += "; " + c.listing.name + ": " + c.listing.missing;
    throw Error(ExitCode::no_device, "no OpenGL 4.3 device was found" + reasons + "; " + advice);
  }
  if (index < 0 || index >= usable)
    throw Error(ExitCode::no_device, "there is no GL device " + std::to_string(index) +
                                         "; this machine has " + std::to_string(usable) +
                                         ", numbered from 0 (see pliant doctor)");
  const Candidate& chosen = all[index];
  if (chosen.kind == "osmesa") return open_osmesa();
  return std::make_unique<EglContext>(chosen.display, chosen.kind.c_str());
}

std::vector<DeviceListing> describe_all() {
  std::vector<DeviceListing> listings;
  for (const Candidate& candidate : candidates()) {
    listings.push_back(candidate.listing);
    if (!candidate.listing.usable) listings.back().missing += "; " + std::string(advice);
  }
  if (listings.empty()) {
    DeviceListing none;
    none.backend = "gl";
    none.name = "OpenGL";
    none.missing = std::string("no OpenGL device was found; ") + advice;
    listings.push_back(none);
  }
  return listings;
}

} // namespace pliant::gl
