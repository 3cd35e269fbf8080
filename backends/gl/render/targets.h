// What a picture is drawn into: samples of colour, normal and depth; the shadow map; visibility; the sum.
#pragma once

#include "backends/gl/context.h"
#include "backends/gl/render/objects.h"

namespace pliant::gl {

struct Targets {
  /// Throws Error(usage) where the device cannot draw a picture of this size.
  Targets(const Context& context, unsigned width, unsigned height, unsigned wanted_samples);

  static constexpr unsigned map = 2048; ///< texels across the shadow map
  unsigned width, height;
  unsigned samples;               ///< of a pixel, in one drawing: what the device has, at most those wanted
  unsigned passes;                ///< drawings that together have the samples wanted
  float first_sample[2] = {0, 0}; ///< pixels from a pixel's middle
  Texture colour, normal, depth;  ///< multisampled
  Texture shadow, rough, between, sum;
  Framebuffer seen, sun, roughly, halfway, summed;
};

} // namespace pliant::gl
