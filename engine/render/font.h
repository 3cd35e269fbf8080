// Text in pictures: a small font of our own, drawn with smooth strokes at any size.
#pragma once

#include "engine/render/image.h"

#include <string>
#include <vector>

namespace pliant {

struct TextSize {
  double width = 0,
         height = 0; ///< pixels; the height is from the top of capitals to the bottom of descenders
};

/// `size` is the height of a capital letter in pixels. Text is ASCII; any other character is drawn as a
/// question mark.
TextSize measure_text(const std::string& text, double size);

/// Draws from (x, y), the upper left corner of the first capital. Upwards: turned by a quarter to the left,
/// with (x, y) the lower left corner of the turned box.
void draw_text(Image& image, double x, double y, const std::string& text, double size, Colour colour,
               bool upwards = false);

/// Lines with smooth edges and round ends, gathered and painted at once: where they cross or join, nothing is
/// painted twice. Positions and widths in pixels; the first pixel reaches from 0 to 1.
class StrokeMask {
public:
  StrokeMask(unsigned width, unsigned height)
      : width_(width), height_(height), cover_(std::size_t(width) * height) {}
  void add(double x0, double y0, double x1, double y1, double width);
  void paint(Image& image, Colour colour) const; ///< a picture of the mask's size

private:
  unsigned width_, height_;
  std::vector<float> cover_; ///< 0 to 1
};

} // namespace pliant
