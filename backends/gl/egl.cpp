// Loads libEGL and libOSMesa at run time.
#include "backends/gl/egl.h"

#include <atomic>
#include <cstring>
#include <dlfcn.h>
#include <initializer_list>
#include <string_view>

namespace pliant::gl {

namespace {

void* open_library(std::initializer_list<const char*> names) {
  for (const char* name : names)
    if (void* library = dlopen(name, RTLD_NOW | RTLD_LOCAL)) return library;
  return nullptr;
}

template <class Function> bool find(void* library, const char* name, Function& function) {
  function = reinterpret_cast<Function>(dlsym(library, name));
  return function != nullptr;
}

template <class Function> void find_extension(const Egl& egl, const char* name, Function& function) {
  function = reinterpret_cast<Function>(egl.get_proc_address(name));
}

std::atomic<const OsMesa*> loaded_osmesa{nullptr};

} // namespace

bool has_extension(const char* list, const char* name) {
  if (!list) return false;
  std::string_view rest = list;
  while (!rest.empty()) {
    const std::size_t end = rest.find(' ');
    if (rest.substr(0, end) == name) return true;
    rest = end == std::string_view::npos ? std::string_view{} : rest.substr(end + 1);
  }
  return false;
}

const Egl* Egl::load() {
  static const Egl* const result = []() -> const Egl* {
    void* library = open_library({"libEGL.so.1", "libEGL.so"});
    if (!library) return nullptr;
    static Egl egl;
    const bool whole =
        find(library, "eglGetProcAddress", egl.get_proc_address) &&
        find(library, "eglQueryString", egl.query_string) && find(library, "eglInitialize", egl.initialize) &&
        find(library, "eglBindAPI", egl.bind_api) && find(library, "eglQueryAPI", egl.query_api) &&
        find(library, "eglChooseConfig", egl.choose_config) &&
        find(library, "eglCreateContext", egl.create_context) &&
        find(library, "eglDestroyContext", egl.destroy_context) &&
        find(library, "eglCreatePbufferSurface", egl.create_pbuffer) &&
        find(library, "eglDestroySurface", egl.destroy_surface) &&
        find(library, "eglMakeCurrent", egl.make_current) &&
        find(library, "eglGetCurrentContext", egl.current_context) &&
        find(library, "eglGetCurrentDisplay", egl.current_display) &&
        find(library, "eglGetCurrentSurface", egl.current_surface) &&
        find(library, "eglGetError", egl.get_error);
    if (!whole) return nullptr;
    const char* client = egl.query_string(nullptr, Egl::extensions);
    if (has_extension(client, "EGL_EXT_platform_base"))
      find_extension(egl, "eglGetPlatformDisplayEXT", egl.get_platform_display);
    if (has_extension(client, "EGL_EXT_device_enumeration") || has_extension(client, "EGL_EXT_device_base"))
      find_extension(egl, "eglQueryDevicesEXT", egl.query_devices);
    return &egl;
  }();
  return result;
}

const OsMesa* OsMesa::load() {
  static const OsMesa* const result = []() -> const OsMesa* {
    void* library = open_library({"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"});
    if (!library) return nullptr;
    static OsMesa osmesa;
    const bool whole = find(library, "OSMesaCreateContextAttribs", osmesa.create_context) &&
                       find(library, "OSMesaDestroyContext", osmesa.destroy_context) &&
                       find(library, "OSMesaMakeCurrent", osmesa.make_current) &&
                       find(library, "OSMesaGetCurrentContext", osmesa.current_context) &&
                       find(library, "OSMesaGetColorBuffer", osmesa.color_buffer) &&
                       find(library, "OSMesaGetProcAddress", osmesa.get_proc_address);
    if (!whole) return nullptr;
    loaded_osmesa = &osmesa;
    return &osmesa;
  }();
  return result;
}

const OsMesa* OsMesa::loaded() {
  return loaded_osmesa;
}

} // namespace pliant::gl
