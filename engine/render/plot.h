// Plots of curves and points, as SVG and as PNG, from one description.
#pragma once

#include "engine/render/image.h"

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

struct SeriesStyle {
  std::optional<Colour> colour; ///< else the next of a palette that colour-blind people can tell apart
  std::optional<unsigned>
      shape; ///< 0 circle, 1 square, 2 triangle, 3 diamond, 4 triangle down, 5 cross, 6 plus; else the next
  bool line = true;
  bool markers = true; ///< thinned where they would touch along a line
  unsigned dashed = 0; ///< 0 unbroken, 1 dashes, 2 dots, 3 long dashes; then again
};

struct Series {
  std::string label; ///< empty: not in the legend
  std::vector<double> x,
      y; ///< equally long; a point that is not finite, or not positive on a log axis, breaks the line
  SeriesStyle style;
};

struct Plot {
  std::string title, x_label, y_label; ///< with units; ASCII in a PNG
  bool log_x = false, log_y = false;
  std::vector<Series> series;
  std::optional<std::array<double, 2>> x_range, y_range; ///< else the data's, rounded outwards
  unsigned width = 960, height = 640;                    ///< pixels, at least 240 x 180
};

/// The plot as a picture.
Image draw_plot(const Plot& plot);
/// Write a file in one rename. Throw Error(input_output); Error(internal) for series of unequal length.
void write_png(const Plot& plot, const std::filesystem::path& path);
void write_svg(const Plot& plot, const std::filesystem::path& path);

} // namespace pliant
