// Keeps what drawing changes in a host's context, and starts drawing from the defaults of OpenGL.
#pragma once

#include "backends/gl/context.h"

#include <array>
#include <utility>
#include <vector>

namespace pliant::gl {

/// The destructor puts back, in a context that belongs to a host, the state that the renderer touches beyond
/// what HostState keeps. Does nothing in a context of our own.
class HostDrawing {
public:
  explicit HostDrawing(const Context& context);
  ~HostDrawing();
  HostDrawing(const HostDrawing&) = delete;
  HostDrawing& operator=(const HostDrawing&) = delete;

private:
  static constexpr int units = 10; ///< texture units that the renderer binds
  struct Unit {
    std::array<int, 4> textures{};
    int sampler = 0;
  };
  const Context& context_;
  std::vector<std::pair<unsigned, bool>> switches_;
  std::array<Unit, units> unit_{};
  std::vector<std::pair<unsigned, int>> pixel_store_;
  std::array<int, 4> viewport_{}, blend_{};
  std::array<int, 2> blend_equation_{};
  std::array<float, 4> blend_colour_{}, clear_colour_{};
  std::array<unsigned char, 4> colour_mask_{};
  double clear_depth_ = 1;
  int draw_ = 0, read_ = 0, array_ = 0, array_buffer_ = 0, active_ = 0, pack_ = 0, unpack_ = 0;
  int depth_function_ = 0, cull_ = 0, front_ = 0, polygon_ = 0;
  unsigned char depth_mask_ = 1;
};

} // namespace pliant::gl
