// Drawn on the CPU into the finished picture.
#include "backends/gl/render/legend.h"

#include "backends/gl/render/palette.h"
#include "engine/render/font.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

namespace pliant::gl {

namespace {

/// Distance of ticks: 1, 2, 2.5 or 5 times a power of ten, about `count` of them.
double tick_step(double range, int count) {
  const double power = std::pow(10, std::floor(std::log10(range / count)));
  for (const double lead : {1.0, 2.0, 2.5, 5.0})
    if (range / (lead * power) <= count) return lead * power;
  return 10 * power;
}

std::string number(double value, double step) {
  char text[32];
  const double size = std::abs(value);
  if (size < 1e-9 * step) return "0";
  if (size >= 1e5 || step < 1e-4)
    std::snprintf(text, sizeof text, "%.3g", value);
  else {
    int digits = std::max(0, static_cast<int>(-std::floor(std::log10(step) + 1e-9)));
    if (std::abs(step * std::pow(10, digits) - std::round(step * std::pow(10, digits))) > 1e-6) ++digits;
    std::snprintf(text, sizeof text, "%.*f", digits, value);
  }
  return text;
}

} // namespace

double legend_unit(unsigned picture_height) {
  return std::clamp(picture_height / 60.0, 5.0, 40.0);
}

void draw_legend(Image& image, const std::string& label, double low, double high, bool open_ended) {
  if (image.width < 160 || image.height < 120) return;
  if (!(high > low)) high = low + std::max(1e-6 * std::abs(low), 1e-12);
  const double unit = legend_unit(image.height);
  const Colour ink{38, 42, 48}, paper{250, 251, 252};
  const int bar_width = static_cast<int>(std::lround(1.3 * unit));
  const int top = static_cast<int>(0.20 * image.height), bottom = static_cast<int>(0.80 * image.height);

  const double step = tick_step(high - low, 6);
  std::vector<std::pair<double, std::string>> ticks;
  double text_width = 0;
  for (double k = std::ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) {
    ticks.emplace_back(k * step, number(k * step, step));
    text_width = std::max(text_width, measure_text(ticks.back().second, unit).width);
  }
  const std::string title = label.empty() ? "field" : label, note = open_ended ? "range so far" : "";
  const double title_width = measure_text(title, unit).width,
               note_width = measure_text(note, 0.8 * unit).width;
  const double column = bar_width + 1.4 * unit + text_width;
  const double wide = std::max({column, title_width, note_width});
  const int left = static_cast<int>(image.width - wide - 2.2 * unit);

  // A pale sheet behind it, so that it reads on any background.
  const int x0 = left - static_cast<int>(unit), x1 = static_cast<int>(image.width - unit);
  const int y0 = top - static_cast<int>(3.2 * unit),
            y1 = bottom + static_cast<int>((open_ended ? 3.2 : 1.4) * unit);
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) image.blend(x, y, paper, 0.72);

  for (int y = top; y < bottom; ++y) {
    const double share = (bottom - 0.5 - y) / (bottom - top);
    const Colour colour =
        field_colours()[static_cast<std::size_t>(std::clamp(share * 255 + 0.5, 0.0, 255.0))];
    for (int x = left; x < left + bar_width; ++x) image.blend(x, y, colour, 1);
  }
  for (int y = top - 1; y <= bottom; ++y) {
    image.blend(left - 1, y, ink, 0.8);
    image.blend(left + bar_width, y, ink, 0.8);
  }
  for (int x = left; x < left + bar_width; ++x) {
    image.blend(x, top - 1, ink, 0.8);
    image.blend(x, bottom, ink, 0.8);
  }
  for (const auto& [value, text] : ticks) {
    const double y = bottom - (value - low) / (high - low) * (bottom - top);
    const int row = static_cast<int>(std::lround(y - 0.5));
    for (int x = 1; x <= static_cast<int>(0.5 * unit); ++x) image.blend(left + bar_width + x, row, ink, 0.9);
    draw_text(image, left + bar_width + 1.0 * unit, y - 0.5 * unit, text, unit, ink);
  }
  draw_text(image, left, top - 2.2 * unit, title, unit, ink);
  if (open_ended) draw_text(image, left, bottom + 1.6 * unit, note, 0.8 * unit, ink);
}

} // namespace pliant::gl
