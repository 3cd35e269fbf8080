// What a plot is drawn on: pixels, or the text of an SVG.
#pragma once

#include "engine/render/image.h"

#include <array>
#include <string>
#include <vector>

namespace pliant {

using Point = std::array<double, 2>; ///< pixels, from the upper left corner

enum class Anchor { start, middle, end };

class Canvas {
public:
  virtual ~Canvas() = default;
  /// Strokes all these lines as one thing.
  virtual void lines(const std::vector<std::vector<Point>>& lines, double width, Colour colour) = 0;
  /// Convex.
  virtual void polygon(const std::vector<Point>& corners, Colour colour, double opacity) = 0;
  /// `at`: the upper edge of the capitals (turned by a quarter to the left: their left edge); `size`: their
  /// height.
  virtual void text(Point at, const std::string& text, double size, Colour colour, Anchor anchor,
                    bool upwards) = 0;
};

class RasterCanvas : public Canvas {
public:
  RasterCanvas(unsigned width, unsigned height) : image(width, height, {255, 255, 255}) {}
  void lines(const std::vector<std::vector<Point>>& lines, double width, Colour colour) override;
  void polygon(const std::vector<Point>& corners, Colour colour, double opacity) override;
  void text(Point at, const std::string& text, double size, Colour colour, Anchor anchor,
            bool upwards) override;
  Image image;
};

class SvgCanvas : public Canvas {
public:
  SvgCanvas(unsigned width, unsigned height);
  void lines(const std::vector<std::vector<Point>>& lines, double width, Colour colour) override;
  void polygon(const std::vector<Point>& corners, Colour colour, double opacity) override;
  void text(Point at, const std::string& text, double size, Colour colour, Anchor anchor,
            bool upwards) override;
  std::string finish() const { return text_ + "</svg>\n"; }

private:
  std::string text_;
};

} // namespace pliant
