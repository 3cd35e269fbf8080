// Plots of curves and points: range, frame, curves, and a legend where it hides nothing.
#include "engine/render/plot.h"

#include "engine/core/error.h"
#include "engine/io/folder.h"
#include "engine/io/png.h"
#include "engine/render/font.h"
#include "engine/render/plot_axis.h"
#include "engine/render/plot_canvas.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pliant {

namespace {

// Okabe and Ito 2008: distinct in all common forms of colour blindness. Their yellow is left out: too pale on
// white.
constexpr std::array<Colour, 7> palette = {
    {{0, 114, 178}, {213, 94, 0}, {0, 158, 115}, {204, 121, 167}, {230, 159, 0}, {86, 180, 233}, {0, 0, 0}}};
constexpr unsigned shapes = 7;
constexpr Colour ink = {40, 40, 40}, grid = {208, 208, 208}, faint = {236, 236, 236}, white = {255, 255, 255};

struct Box {
  double left, top, right, bottom; ///< pixels
  double width() const { return right - left; }
  double height() const { return bottom - top; }
};

struct Sizes {
  double tick, label, title, line, marker, gap; ///< heights of capitals, widths, radius, distance; pixels
};

// The part of a segment inside a box; false where there is none (Liang and Barsky 1984).
bool clip(Point& a, Point& b, const Box& box) {
  const double dx = b[0] - a[0], dy = b[1] - a[1];
  double from = 0, to = 1;
  const std::array<std::array<double, 2>, 4> sides = {
      {{-dx, a[0] - box.left}, {dx, box.right - a[0]}, {-dy, a[1] - box.top}, {dy, box.bottom - a[1]}}};
  for (const auto& [speed, room] : sides) {
    if (speed == 0 && room < 0) return false;
    if (speed < 0) from = std::max(from, room / speed);
    if (speed > 0) to = std::min(to, room / speed);
  }
  if (from > to) return false;
  const Point start = a;
  a = {start[0] + from * dx, start[1] + from * dy};
  b = {start[0] + to * dx, start[1] + to * dy};
  return true;
}

// `kind`: see SeriesStyle; `width`: of the line.
std::vector<std::vector<Point>> dashed(const std::vector<std::vector<Point>>& lines, unsigned kind,
                                       double width) {
  constexpr std::array<std::array<double, 2>, 3> patterns = {{{3, 3}, {1, 2}, {7, 3}}};
  if (kind % 4 == 0) return lines;
  const double on = patterns[kind % 4 - 1][0] * width, off = patterns[kind % 4 - 1][1] * width;
  std::vector<std::vector<Point>> dashes;
  for (const auto& line : lines) {
    double travelled = 0;
    bool drawing = false;
    for (std::size_t i = 1; i < line.size(); ++i) {
      const Point &a = line[i - 1], &b = line[i];
      const double length = std::hypot(b[0] - a[0], b[1] - a[1]);
      for (double at = 0; at < length;) {
        const double phase = std::fmod(travelled, on + off);
        const bool now = phase < on;
        const double next = std::min(length, at + std::max((now ? on : on + off) - phase, 1e-3));
        const auto point = [&](double s) {
          return Point{a[0] + (b[0] - a[0]) * s / length, a[1] + (b[1] - a[1]) * s / length};
        };
        if (now && !drawing) dashes.push_back({point(at)});
        if (now) dashes.back().push_back(point(next));
        drawing = now;
        travelled += next - at;
        at = next;
      }
    }
  }
  return dashes;
}

void draw_marker(Canvas& canvas, Point at, unsigned shape, double radius, Colour colour) {
  if (shape >= 5) {
    const double r = radius, d = shape == 5 ? 0.75 * r : 0;
    const std::vector<std::vector<Point>> cross =
        shape == 5 ? std::vector<std::vector<Point>>{{{at[0] - d, at[1] - d}, {at[0] + d, at[1] + d}},
                                                     {{at[0] - d, at[1] + d}, {at[0] + d, at[1] - d}}}
                   : std::vector<std::vector<Point>>{{{at[0] - r, at[1]}, {at[0] + r, at[1]}},
                                                     {{at[0], at[1] - r}, {at[0], at[1] + r}}};
    canvas.lines(cross, 0.45 * radius, colour);
    return;
  }
  struct Form {
    int corners;
    double start, scale; ///< angle of the first corner in turns; radius, for areas that look alike
  };
  constexpr std::array<Form, 5> forms = {
      {{24, 0, 0.95}, {4, 0.125, 1.2}, {3, 0.75, 1.3}, {4, 0, 1.25}, {3, 0.25, 1.3}}};
  const Form& form = forms[shape];
  std::vector<Point> corners;
  for (int i = 0; i < form.corners; ++i) {
    const double angle = 2 * std::numbers::pi * (form.start + double(i) / form.corners);
    corners.push_back(
        {at[0] + form.scale * radius * std::cos(angle), at[1] + form.scale * radius * std::sin(angle)});
  }
  canvas.polygon(corners, colour, 1);
}

Colour colour_of(const Plot& plot, std::size_t i) {
  return plot.series[i].style.colour.value_or(palette[i % palette.size()]);
}
unsigned shape_of(const Plot& plot, std::size_t i) {
  return plot.series[i].style.shape.value_or(static_cast<unsigned>(i)) % shapes;
}

// A plot with all its places known.
class Sheet {
public:
  explicit Sheet(const Plot& plot);
  void draw(Canvas& canvas) const;

private:
  struct Curve {
    std::vector<std::vector<Point>> lines; ///< inside the frame
    std::vector<Point> markers;
  };
  bool is_map() const;
  Axis axis(bool x) const;
  void place_frame(double legend_room);
  void place_curves();
  Point at(double x, double y) const;
  Box legend_size() const;
  bool find_room_for_legend();
  double covered(const Box& box) const;
  void draw_frame(Canvas& canvas) const;
  void draw_legend(Canvas& canvas) const;

  const Plot& plot_;
  Sizes sizes_;
  Axis x_, y_;
  Box frame_ = {}, legend_ = {};
  std::vector<Curve> curves_;
};

// Points without lines are a map: a legend among them could be taken for one of them.
bool Sheet::is_map() const {
  return std::any_of(plot_.series.begin(), plot_.series.end(), [](const Series& s) { return !s.style.line; });
}

Axis Sheet::axis(bool x) const {
  double low = 1e308, high = -1e308;
  for (const Series& series : plot_.series)
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      if (!std::isfinite(series.x[i]) || !std::isfinite(series.y[i]) || (plot_.log_x && series.x[i] <= 0) ||
          (plot_.log_y && series.y[i] <= 0))
        continue;
      const double value = x ? series.x[i] : series.y[i];
      low = std::min(low, value), high = std::max(high, value);
    }
  const double room = x ? plot_.width : plot_.height, share = x ? 12 * sizes_.tick : 6 * sizes_.tick;
  // The outermost points of a map should not lie on the frame.
  return {x ? plot_.log_x : plot_.log_y,
          low,
          high,
          x ? plot_.x_range : plot_.y_range,
          static_cast<int>(room / share),
          is_map() ? 2.5 * sizes_.marker / room : 0};
}

Sheet::Sheet(const Plot& plot)
    : plot_(plot), sizes_([&] {
        const double s = std::clamp(std::min(plot.width / 960.0, plot.height / 640.0), 0.6, 4.0);
        return Sizes{9.5 * s, 10.5 * s, 12.5 * s, 2 * s, 4.2 * s, 8 * s};
      }()),
      x_(axis(true)), y_(axis(false)) {
  place_frame(0);
  place_curves();
  if (find_room_for_legend()) return;
  // Beside the plot, then.
  const Box size = legend_size();
  place_frame(size.width() + 1.5 * sizes_.gap);
  place_curves();
  const double left = frame_.right + 1.5 * sizes_.gap;
  legend_ = {left, frame_.top, left + size.width(), frame_.top + size.height()};
}

void Sheet::place_frame(double legend_room) {
  const Sizes& s = sizes_;
  double widest = 0, last = 0;
  for (const Tick& tick : y_.ticks()) widest = std::max(widest, measure_text(tick.label, s.tick).width);
  for (const Tick& tick : x_.ticks()) last = std::max(last, measure_text(tick.label, s.tick).width);
  frame_.left = 1.5 * s.gap + (plot_.y_label.empty() ? 0 : 9.0 / 7 * s.label + s.gap) + widest + s.gap;
  frame_.right = plot_.width - std::max(2 * s.gap, last / 2 + s.gap) - legend_room;
  frame_.top = 2 * s.gap + (plot_.title.empty() ? 0 : s.title + 1.5 * s.gap);
  frame_.bottom =
      plot_.height - 1.5 * s.gap - (plot_.x_label.empty() ? 0 : 9.0 / 7 * s.label + s.gap) - s.tick - s.gap;
  // Lines of one pixel lie on pixel centres.
  for (double* edge : {&frame_.left, &frame_.top, &frame_.right, &frame_.bottom})
    *edge = std::floor(*edge) + 0.5;
}

Point Sheet::at(double x, double y) const {
  return {frame_.left + x_.place(x) * frame_.width(), frame_.bottom - y_.place(y) * frame_.height()};
}

void Sheet::place_curves() {
  curves_.assign(plot_.series.size(), {});
  for (std::size_t k = 0; k < plot_.series.size(); ++k) {
    const Series& series = plot_.series[k];
    Curve& curve = curves_[k];
    bool joined = false;
    Point before = {}, last_marker = {-1e9, -1e9};
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      if (!x_.can_show(series.x[i]) || !y_.can_show(series.y[i])) {
        joined = false;
        continue;
      }
      const Point here = at(series.x[i], series.y[i]);
      const bool inside = here[0] >= frame_.left - 0.5 && here[0] <= frame_.right + 0.5 &&
                          here[1] >= frame_.top - 0.5 && here[1] <= frame_.bottom + 0.5;
      const double apart = series.style.line ? 5 * sizes_.marker : 0;
      if (inside && series.style.markers &&
          std::hypot(here[0] - last_marker[0], here[1] - last_marker[1]) >= apart) {
        curve.markers.push_back(here);
        last_marker = here;
      }
      if (!series.style.line) continue;
      if (joined && std::hypot(here[0] - before[0], here[1] - before[1]) < 0.25) continue;
      Point a = before, b = here;
      if (joined && clip(a, b, frame_)) {
        if (curve.lines.empty() || curve.lines.back().back() != a) curve.lines.push_back({a});
        curve.lines.back().push_back(b);
      }
      before = here;
      joined = true;
    }
  }
}

Box Sheet::legend_size() const {
  double widest = 0, rows = 0;
  for (const Series& series : plot_.series)
    if (!series.label.empty())
      widest = std::max(widest, measure_text(series.label, sizes_.tick).width), ++rows;
  if (rows == 0) return {};
  return {0, 0, 5.5 * sizes_.gap + widest + sizes_.gap, sizes_.gap + rows * 1.9 * sizes_.tick};
}

// How much of the data a box hides, in sample points, its surroundings included.
double Sheet::covered(const Box& box) const {
  const double room = sizes_.marker + 2;
  const auto inside = [&](const Point& p) {
    return p[0] > box.left - room && p[0] < box.right + room && p[1] > box.top - room &&
           p[1] < box.bottom + room;
  };
  double count = 0;
  for (const Curve& curve : curves_) {
    for (const Point& marker : curve.markers) count += inside(marker);
    for (const auto& line : curve.lines)
      for (std::size_t i = 1; i < line.size(); ++i) {
        Point a = line[i - 1], b = line[i];
        count += clip(a, b, {box.left - room, box.top - room, box.right + room, box.bottom + room});
      }
  }
  return count;
}

bool Sheet::find_room_for_legend() {
  const Box size = legend_size();
  if (size.width() == 0) return true;
  const double inset = 1.25 * sizes_.gap;
  const double across = frame_.width() - size.width() - 2 * inset,
               down = frame_.height() - size.height() - 2 * inset;
  if (is_map() || across < 0 || down < 0 ||
      size.width() * size.height() > 0.3 * frame_.width() * frame_.height())
    return false;
  // Corners first, then along the edges; the middle would look lost.
  std::vector<Point> places = {{1, 0}, {0, 0}, {1, 1}, {0, 1}};
  for (const double t : {0.5, 0.25, 0.75}) places.insert(places.end(), {{1, t}, {t, 0}, {0, t}, {t, 1}});
  for (const Point& place : places) {
    const double left = frame_.left + inset + place[0] * across, top = frame_.top + inset + place[1] * down;
    legend_ = {left, top, left + size.width(), top + size.height()};
    if (covered(legend_) == 0) return true;
  }
  return false;
}

void Sheet::draw_frame(Canvas& canvas) const {
  const Box& f = frame_;
  const Sizes& s = sizes_;
  std::vector<std::vector<Point>> major, minor, marks;
  for (const bool is_x : {true, false})
    for (const Tick& tick : (is_x ? x_ : y_).ticks()) {
      const double share = (is_x ? x_ : y_).place(tick.value);
      if (share < -1e-6 || share > 1 + 1e-6) continue;
      const double along =
          std::floor(is_x ? f.left + share * f.width() : f.bottom - share * f.height()) + 0.5;
      const double length = tick.label.empty() ? 0.35 * s.gap : 0.7 * s.gap;
      if (is_x) {
        (tick.label.empty() ? minor : major).push_back({{along, f.top}, {along, f.bottom}});
        marks.push_back({{along, f.bottom}, {along, f.bottom - length}});
        canvas.text({along, f.bottom + s.gap}, tick.label, s.tick, ink, Anchor::middle, false);
      } else {
        (tick.label.empty() ? minor : major).push_back({{f.left, along}, {f.right, along}});
        marks.push_back({{f.left, along}, {f.left + length, along}});
        canvas.text({f.left - s.gap, along - s.tick / 2}, tick.label, s.tick, ink, Anchor::end, false);
      }
    }
  canvas.lines(minor, 1, faint);
  canvas.lines(major, 1, grid);
  canvas.lines(
      {{{f.left, f.top}, {f.right, f.top}, {f.right, f.bottom}, {f.left, f.bottom}, {f.left, f.top}}}, 1,
      ink);
  canvas.lines(marks, 1, ink);
  const double middle = (f.left + f.right) / 2;
  canvas.text({middle, 2 * s.gap}, plot_.title, s.title, ink, Anchor::middle, false);
  canvas.text({middle, f.bottom + 2 * s.gap + s.tick}, plot_.x_label, s.label, ink, Anchor::middle, false);
  canvas.text({1.5 * s.gap, (f.top + f.bottom) / 2}, plot_.y_label, s.label, ink, Anchor::middle, true);
}

void Sheet::draw_legend(Canvas& canvas) const {
  if (legend_.width() == 0) return;
  const Box& b = legend_;
  const std::vector<Point> outline = {
      {b.left, b.top}, {b.right, b.top}, {b.right, b.bottom}, {b.left, b.bottom}};
  canvas.polygon(outline, white, 0.9);
  canvas.lines({{outline[0], outline[1], outline[2], outline[3], outline[0]}}, 1, grid);
  double y = b.top + 0.5 * sizes_.gap + 0.95 * sizes_.tick;
  for (std::size_t i = 0; i < plot_.series.size(); ++i) {
    const Series& series = plot_.series[i];
    if (series.label.empty()) continue;
    const double left = b.left + sizes_.gap, right = left + 3.5 * sizes_.gap;
    const std::vector<std::vector<Point>> sample = {{{left, y}, {right, y}}};
    if (series.style.line)
      canvas.lines(dashed(sample, series.style.dashed, sizes_.line), sizes_.line, colour_of(plot_, i));
    if (series.style.markers)
      draw_marker(canvas, {(left + right) / 2, y}, shape_of(plot_, i), sizes_.marker, colour_of(plot_, i));
    canvas.text({right + sizes_.gap, y - sizes_.tick / 2}, series.label, sizes_.tick, ink, Anchor::start,
                false);
    y += 1.9 * sizes_.tick;
  }
}

void Sheet::draw(Canvas& canvas) const {
  draw_frame(canvas);
  bool empty = true;
  for (std::size_t i = 0; i < curves_.size(); ++i) {
    const Curve& curve = curves_[i];
    const Colour colour = colour_of(plot_, i);
    canvas.lines(dashed(curve.lines, plot_.series[i].style.dashed, sizes_.line), sizes_.line, colour);
    for (const Point& marker : curve.markers)
      draw_marker(canvas, marker, shape_of(plot_, i), sizes_.marker, colour);
    empty = empty && curve.lines.empty() && curve.markers.empty();
  }
  if (empty)
    canvas.text({(frame_.left + frame_.right) / 2, (frame_.top + frame_.bottom) / 2}, "no data", sizes_.title,
                ink, Anchor::middle, false);
  draw_legend(canvas);
}

Sheet sheet_of(const Plot& plot) {
  for (const Series& series : plot.series)
    if (series.x.size() != series.y.size())
      throw Error(ExitCode::internal,
                  fmt::format("series \"{}\" of the plot \"{}\" has {} x and {} y", series.label, plot.title,
                              series.x.size(), series.y.size()));
  if (plot.width < 240 || plot.height < 180)
    throw Error(ExitCode::internal,
                fmt::format("a plot of {} x {} pixels is too small", plot.width, plot.height));
  return Sheet(plot);
}

} // namespace

Image draw_plot(const Plot& plot) {
  RasterCanvas canvas(plot.width, plot.height);
  sheet_of(plot).draw(canvas);
  return canvas.image;
}

void write_png(const Plot& plot, const std::filesystem::path& path) {
  write_png(draw_plot(plot), path);
}

void write_svg(const Plot& plot, const std::filesystem::path& path) {
  SvgCanvas canvas(plot.width, plot.height);
  sheet_of(plot).draw(canvas);
  write_text_file(path, canvas.finish());
}

} // namespace pliant
