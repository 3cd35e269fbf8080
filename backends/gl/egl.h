// EGL and OSMesa, found at run time: the few functions and numbers that a headless context needs. Written out
// here, so that neither their libraries nor their headers are needed to build.
#pragma once

#include <cstdint>

namespace pliant::gl {

/// The functions of libEGL. Handles are opaque pointers, as in the EGL 1.5 specification.
struct Egl {
  using Boolean = unsigned;
  using Int = std::int32_t;

  static constexpr Int none = 0x3038, extensions = 0x3055, opengl_api = 0x30A2, opengl_bit = 0x0008;
  static constexpr Int surface_type = 0x3033, pbuffer_bit = 0x0001, renderable_type = 0x3040;
  static constexpr Int width = 0x3057, height = 0x3056, draw = 0x3059, read = 0x305A;
  static constexpr Int context_major = 0x3098, context_minor = 0x30FB;
  static constexpr Int profile_mask = 0x30FD, core_profile_bit = 0x0001;
  static constexpr unsigned platform_device = 0x313F, platform_surfaceless = 0x31DD;

  void* (*get_proc_address)(const char*) = nullptr;
  const char* (*query_string)(void* display, Int name) = nullptr;
  Boolean (*initialize)(void* display, Int* major, Int* minor) = nullptr;
  Boolean (*bind_api)(unsigned api) = nullptr;
  unsigned (*query_api)() = nullptr;
  Boolean (*choose_config)(void* display, const Int* attributes, void** configs, Int size,
                           Int* count) = nullptr;
  void* (*create_context)(void* display, void* config, void* share, const Int* attributes) = nullptr;
  Boolean (*destroy_context)(void* display, void* context) = nullptr;
  void* (*create_pbuffer)(void* display, void* config, const Int* attributes) = nullptr;
  Boolean (*destroy_surface)(void* display, void* surface) = nullptr;
  Boolean (*make_current)(void* display, void* draw, void* read, void* context) = nullptr;
  void* (*current_context)() = nullptr;
  void* (*current_display)() = nullptr;
  void* (*current_surface)(Int which) = nullptr;
  Int (*get_error)() = nullptr;
  void* (*get_platform_display)(unsigned platform, void* native,
                                const Int* attributes) = nullptr;           // may be null
  Boolean (*query_devices)(Int size, void** devices, Int* count) = nullptr; // may be null

  /// Null where the library is missing. Loaded once, kept for the life of the process.
  static const Egl* load();
};

/// The functions of libOSMesa: Mesa's software GL in main memory, gone from Mesa 25.1 on.
struct OsMesa {
  static constexpr int format = 0x22, rgba = 0x1908, profile = 0x33, core_profile = 0x34;
  static constexpr int context_major = 0x36, context_minor = 0x37;
  static constexpr unsigned unsigned_byte = 0x1401;

  void* (*create_context)(const int* attributes, void* share) = nullptr;
  void (*destroy_context)(void* context) = nullptr;
  unsigned char (*make_current)(void* context, void* pixels, unsigned type, int width, int height) = nullptr;
  void* (*current_context)() = nullptr;
  unsigned char (*color_buffer)(void* context, int* width, int* height, int* format, void** pixels) = nullptr;
  void* (*get_proc_address)(const char*) = nullptr;

  /// Null where the library is missing or too old for core contexts.
  static const OsMesa* load();
  /// What load() gave, without loading: null before.
  static const OsMesa* loaded();
};

/// True when `name` is a word of `list`.
bool has_extension(const char* list, const char* name);

} // namespace pliant::gl
