// Pixels in memory: 8 bits a channel, rows from the top.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace pliant {

using Colour = std::array<std::uint8_t, 3>; ///< sRGB

struct Image {
  unsigned width = 0, height = 0;
  unsigned channels = 3; ///< 3 RGB, 4 RGBA
  std::vector<std::uint8_t> pixels;

  Image() = default;
  Image(unsigned w, unsigned h, Colour fill, unsigned channel_count = 3)
      : width(w), height(h), channels(channel_count), pixels(std::size_t(w) * h * channel_count, 255) {
    for (std::size_t i = 0; i < std::size_t(w) * h; ++i)
      for (unsigned c = 0; c < 3; ++c) pixels[i * channels + c] = fill[c];
  }
  std::uint8_t* at(unsigned x, unsigned y) { return &pixels[(std::size_t(y) * width + x) * channels]; }
  const std::uint8_t* at(unsigned x, unsigned y) const {
    return &pixels[(std::size_t(y) * width + x) * channels];
  }

  /// Mixes a colour into a pixel; coverage 0 to 1. Nothing happens outside the picture.
  void blend(int x, int y, Colour colour, double coverage) {
    if (x < 0 || y < 0 || x >= static_cast<int>(width) || y >= static_cast<int>(height)) return;
    const double share = coverage < 0 ? 0 : coverage > 1 ? 1 : coverage;
    std::uint8_t* pixel = at(static_cast<unsigned>(x), static_cast<unsigned>(y));
    for (unsigned c = 0; c < 3; ++c)
      pixel[c] = static_cast<std::uint8_t>(std::lround(pixel[c] + (colour[c] - pixel[c]) * share));
    if (channels == 4) pixel[3] = static_cast<std::uint8_t>(std::lround(pixel[3] + (255 - pixel[3]) * share));
  }
};

} // namespace pliant
