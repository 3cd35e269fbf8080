// What a plot is drawn on: pixels, or the text of an SVG.
#include "engine/render/plot_canvas.h"

#include "engine/render/font.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace pliant {

// ---- pixels

void RasterCanvas::lines(const std::vector<std::vector<Point>>& lines, double width, Colour colour) {
  StrokeMask mask(image.width, image.height);
  for (const auto& line : lines)
    for (std::size_t i = 1; i < line.size(); ++i)
      mask.add(line[i - 1][0], line[i - 1][1], line[i][0], line[i][1], width);
  mask.paint(image, colour);
}

void RasterCanvas::polygon(const std::vector<Point>& corners, Colour colour, double opacity) {
  double left = 1e30, top = 1e30, right = -1e30, bottom = -1e30, area = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Point &a = corners[i], &b = corners[(i + 1) % corners.size()];
    left = std::min(left, a[0]), right = std::max(right, a[0]);
    top = std::min(top, a[1]), bottom = std::max(bottom, a[1]);
    area += a[0] * b[1] - a[1] * b[0];
  }
  const double turn = area < 0 ? -1 : 1;
  const auto inside = [&](double x, double y) {
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Point &a = corners[i], &b = corners[(i + 1) % corners.size()];
      if (turn * ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) < 0) return false;
    }
    return true;
  };
  constexpr int fine = 4; // samples a side of a pixel
  const int x_end = std::min(static_cast<int>(std::ceil(right)), static_cast<int>(image.width));
  const int y_end = std::min(static_cast<int>(std::ceil(bottom)), static_cast<int>(image.height));
  for (int y = std::max(0, static_cast<int>(std::floor(top))); y < y_end; ++y)
    for (int x = std::max(0, static_cast<int>(std::floor(left))); x < x_end; ++x) {
      int hits = 0;
      for (int i = 0; i < fine * fine; ++i)
        hits += inside(x + (i % fine + 0.5) / fine, y + (i / fine + 0.5) / fine);
      image.blend(x, y, colour, opacity * hits / (fine * fine));
    }
}

void RasterCanvas::text(Point at, const std::string& text, double size, Colour colour, Anchor anchor,
                        bool upwards) {
  const double length = measure_text(text, size).width;
  const double back = anchor == Anchor::start ? 0 : anchor == Anchor::middle ? length / 2 : length;
  // Whole pixels keep the strokes of a line of text alike.
  const double x = std::round(at[0] - (upwards ? 0 : back)), y = std::round(at[1] + (upwards ? back : 0));
  draw_text(image, x, y, text, size, colour, upwards);
}

// ---- SVG

namespace {

std::string hex(Colour colour) {
  return fmt::format("#{:02x}{:02x}{:02x}", colour[0], colour[1], colour[2]);
}

std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '&')
      safe += "&amp;";
    else if (c == '<')
      safe += "&lt;";
    else if (c == '>')
      safe += "&gt;";
    else if (static_cast<unsigned char>(c) >= 32)
      safe += c;
  }
  return safe;
}

} // namespace

SvgCanvas::SvgCanvas(unsigned width, unsigned height)
    : text_(fmt::format(
          "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
          "font-family=\"DejaVu Sans, Verdana, Helvetica, Arial, sans-serif\">\n"
          "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
          width, height)) {}

void SvgCanvas::lines(const std::vector<std::vector<Point>>& lines, double width, Colour colour) {
  std::string path;
  for (const auto& line : lines)
    for (std::size_t i = 0; i < line.size(); ++i)
      path += fmt::format("{}{:.2f} {:.2f}", i == 0 ? "M" : "L", line[i][0], line[i][1]);
  if (path.empty()) return;
  text_ += fmt::format(
      "<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{:.2f}\" stroke-linejoin=\"round\" "
      "stroke-linecap=\"round\"/>\n",
      path, hex(colour), width);
}

void SvgCanvas::polygon(const std::vector<Point>& corners, Colour colour, double opacity) {
  std::string points;
  for (const Point& corner : corners) points += fmt::format("{:.2f},{:.2f} ", corner[0], corner[1]);
  text_ += fmt::format("<polygon points=\"{}\" fill=\"{}\"{}/>\n", points, hex(colour),
                       opacity < 1 ? fmt::format(" fill-opacity=\"{:.2f}\"", opacity) : "");
}

void SvgCanvas::text(Point at, const std::string& text, double size, Colour colour, Anchor anchor,
                     bool upwards) {
  const char* where = anchor == Anchor::start ? "start" : anchor == Anchor::middle ? "middle" : "end";
  // The baseline lies a capital's height further on; a capital is about 0.72 of the font's size.
  const double x = upwards ? at[0] + size : at[0], y = upwards ? at[1] : at[1] + size;
  text_ += fmt::format(
      "<text x=\"{:.2f}\" y=\"{:.2f}\" font-size=\"{:.2f}\" fill=\"{}\" text-anchor=\"{}\"{}>{}</text>\n", x,
      y, size / 0.72, hex(colour), where,
      upwards ? fmt::format(" transform=\"rotate(-90 {:.2f} {:.2f})\"", x, y) : "", escaped(text));
}

} // namespace pliant
