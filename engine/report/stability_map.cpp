// Draws the sweep.
//
//   +--------+ +--------+   maps: Young's modulus up, time step to the right;       list: a row a problem,
//   | method | | method |   colour and number: iterations a step                    a column a method and
//   | device | | device |   a cell that failed has the colour of its failure        backend
//   +--------+ +--------+
#include "engine/report/stability_map.h"

#include "engine/io/folder.h"
#include "engine/io/png.h"
#include "engine/render/font.h"
#include "engine/render/plot_canvas.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <set>
#include <tuple>

namespace pliant {

namespace {

constexpr Colour ink = {40, 40, 40}, line_colour = {200, 200, 200}, white = {255, 255, 255};
constexpr Colour not_finite_colour = {0, 0, 0}, unbounded_colour = {190, 30, 45},
                 unrecovered_colour = {240, 150, 30}, refused_colour = {190, 190, 190};
constexpr double small = 8, normal = 9.5, large = 13; ///< heights of capitals, pixels
constexpr double margin = 24;

/// From pale green to deep blue over the logarithm of the iterations a step, 1 to 1000.
Colour effort_colour(double iterations) {
  const double share = std::clamp(std::log10(std::max(iterations, 1.0)) / 3, 0.0, 1.0);
  constexpr Colour few = {214, 239, 208}, some = {78, 162, 190}, many = {20, 50, 120};
  const auto mix = [](Colour a, Colour b, double t) {
    Colour c{};
    for (std::size_t k = 0; k < 3; ++k)
      c[k] = static_cast<std::uint8_t>(std::lround(a[k] + (b[k] - a[k]) * t));
    return c;
  };
  return share < 0.5 ? mix(few, some, 2 * share) : mix(some, many, 2 * share - 1);
}

double effort(const StabilityCell& cell) {
  return cell.steps == 0 ? 0 : static_cast<double>(cell.iterations) / cell.steps;
}

Colour colour_of(const StabilityCell& cell) {
  if (!cell.finite) return not_finite_colour;
  if (!cell.bounded) return unbounded_colour;
  if (!cell.good()) return unrecovered_colour;
  return cell.refused ? refused_colour : effort_colour(effort(cell));
}

Colour text_colour(Colour under) {
  return under[0] * 0.3 + under[1] * 0.59 + under[2] * 0.11 > 130 ? ink : white;
}

std::string text_of(const StabilityCell& cell) {
  if (!cell.finite) return "NaN";
  if (!cell.bounded) return "far";
  if (cell.refused) return "-";
  return fmt::format("{:.0f}", effort(cell));
}

void box(Canvas& canvas, double x, double y, double width, double height, Colour colour) {
  canvas.polygon({{x, y}, {x + width, y}, {x + width, y + height}, {x, y + height}}, colour, 1);
}

/// One cell of a map or of the list.
void draw_cell(Canvas& canvas, const StabilityCell& cell, double x, double y, double width, double height) {
  const Colour colour = colour_of(cell);
  box(canvas, x + 0.5, y + 0.5, width - 1, height - 1, colour);
  canvas.text({x + width / 2, y + (height - small) / 2}, text_of(cell), small, text_colour(colour),
              Anchor::middle, false);
}

/// Powers of ten, fractions as typed (1/30), else two digits.
std::string power(double value) {
  const double exponent = std::log10(value);
  if (std::abs(exponent - std::round(exponent)) < 1e-6) return fmt::format("1e{:.0f}", exponent);
  return value < 1 && value > 1e-4 ? fmt::format("1/{:.0f}", 1 / value) : fmt::format("{:.2g}", value);
}

std::string young_text(double value) {
  const std::string text = fmt::format("{:.0e}", value); // 1e+06
  return text.substr(0, 2) + text.substr(text.size() - (text[text.size() - 2] == '0' ? 1 : 2));
}

/// A column: a method on a backend.
using Column = std::pair<std::string, std::string>;

struct Row {
  std::string name;
  double young, poisson, time_step;
  bool operator==(const Row&) const = default;
  bool operator<(const Row& other) const {
    return std::tie(name, young, poisson, time_step) <
           std::tie(other.name, other.young, other.poisson, other.time_step);
  }
};

class Map {
public:
  explicit Map(const StabilityReport& report) : report_(report) {
    std::set<double> youngs, steps;
    for (const StabilityCell& cell : report.cells) {
      const Column column{cell.method, cell.backend};
      if (std::find(columns_.begin(), columns_.end(), column) == columns_.end()) columns_.push_back(column);
      if (std::find(methods_.begin(), methods_.end(), cell.method) == methods_.end())
        methods_.push_back(cell.method);
      if (std::find(backends_.begin(), backends_.end(), cell.backend) == backends_.end())
        backends_.push_back(cell.backend);
      if (cell.map) {
        youngs.insert(cell.young), steps.insert(cell.time_step);
      } else {
        const Row row = row_of(cell);
        if (std::find(rows_.begin(), rows_.end(), row) == rows_.end()) rows_.push_back(row);
      }
      at_[{row_of(cell), column}] = &cell;
    }
    youngs_.assign(youngs.begin(), youngs.end());
    steps_.assign(steps.begin(), steps.end());
    std::stable_sort(columns_.begin(), columns_.end(), [this](const Column& a, const Column& b) {
      return place(backends_, a.second) < place(backends_, b.second);
    });
    const double maps_wide =
        youngs_.empty() ? 0 : static_cast<double>(methods_.size()) * (map_width() + map_left) + margin;
    list_left_ = margin + maps_wide;
    width_ = std::max(list_left_ + label_width + static_cast<double>(columns_.size()) * list_cell + margin,
                      legend_width);
    const double maps_high =
        youngs_.empty() ? 0 : static_cast<double>(backends_.size()) * (map_height() + map_top) + 30;
    const double list_high = list_head + static_cast<double>(rows_.size()) * list_row;
    height_ = head + std::max(maps_high, list_high) + margin;
  }

  unsigned width() const { return static_cast<unsigned>(width_); }
  unsigned height() const { return static_cast<unsigned>(height_); }

  void draw(Canvas& canvas) const {
    const StabilityReport& r = report_;
    canvas.text({margin, margin},
                fmt::format("Stability of {}: {} cells, {} not finite, {} unbounded, {} unrecovered", r.scene,
                            r.cells.size(), r.non_finite(), r.unbounded(), r.unrecovered()),
                large, ink, Anchor::start, false);
    draw_legend(canvas, margin, margin + 30);
    if (!youngs_.empty())
      for (std::size_t b = 0; b < backends_.size(); ++b)
        for (std::size_t m = 0; m < methods_.size(); ++m)
          draw_map(canvas, {methods_[m], backends_[b]},
                   margin + map_left + static_cast<double>(m) * (map_width() + map_left),
                   head + map_top + static_cast<double>(b) * (map_height() + map_top));
    if (!rows_.empty()) draw_list(canvas, list_left_, head);
  }

private:
  static constexpr double head = 90, map_left = 62, map_top = 66, map_cell = 46, map_row = 22;
  static constexpr double list_head = 84, list_row = 17, list_cell = 40, label_width = 445;
  static constexpr double legend_width = 1310; ///< the least that draw_legend() needs
  static constexpr double young_at = 292, ratio_at = 343, step_at = 388; ///< columns of the list

  double map_width() const { return static_cast<double>(steps_.size()) * map_cell; }
  double map_height() const { return static_cast<double>(youngs_.size()) * map_row; }
  static Row row_of(const StabilityCell& cell) {
    return {cell.name, cell.young, cell.poisson, cell.time_step};
  }
  static std::ptrdiff_t place(const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) - names.begin();
  }

  void draw_legend(Canvas& canvas, double x, double y) const {
    const auto words = [&](const std::string& text, double after) {
      canvas.text({x, y + (14 - normal) / 2}, text, normal, ink, Anchor::start, false);
      x += measure_text(text, normal).width + after;
    };
    const auto entry = [&](Colour colour, const std::string& text) {
      box(canvas, x, y, 18, 14, colour);
      x += 26;
      words(text, 22);
    };
    entry(not_finite_colour, "not finite");
    entry(unbounded_colour, "unbounded");
    entry(unrecovered_colour, "not recovered");
    entry(refused_colour, "refused, as it should be");
    words("good, with mean iterations a step:", 10);
    for (double iterations : {1., 3., 10., 30., 100., 300., 1000.}) {
      const Colour colour = effort_colour(iterations);
      box(canvas, x, y, 38, 14, colour);
      canvas.text({x + 19, y + 3}, fmt::format("{:.0f}", iterations), small, text_colour(colour),
                  Anchor::middle, false);
      x += 38;
    }
  }

  void draw_map(Canvas& canvas, const Column& column, double x, double y) const {
    canvas.text({x + map_width() / 2, y - 22}, column.first + ", " + column.second, normal, ink,
                Anchor::middle, false);
    for (std::size_t row = 0; row < youngs_.size(); ++row) {
      const double top = y + static_cast<double>(youngs_.size() - 1 - row) * map_row;
      canvas.text({x - 6, top + (map_row - small) / 2}, power(youngs_[row]), small, ink, Anchor::end, false);
      for (std::size_t step = 0; step < steps_.size(); ++step)
        for (const auto& [key, cell] : at_) // few: the ratio of the map is the scene's
          if (key.second == column && cell->map && cell->young == youngs_[row] &&
              cell->time_step == steps_[step])
            draw_cell(canvas, *cell, x + static_cast<double>(step) * map_cell, top, map_cell, map_row);
    }
    for (std::size_t step = 0; step < steps_.size(); ++step)
      canvas.text({x + (static_cast<double>(step) + 0.5) * map_cell, y + map_height() + 5},
                  power(steps_[step]), small, ink, Anchor::middle, false);
    canvas.text({x + map_width() / 2, y + map_height() + 20}, "time step (s)", small, ink, Anchor::middle,
                false);
    canvas.text({x - 50, y + map_height() / 2}, "Young's modulus (Pa)", small, ink, Anchor::middle, true);
    canvas.lines(
        {{{x, y}, {x + map_width(), y}, {x + map_width(), y + map_height()}, {x, y + map_height()}, {x, y}}},
        1, ink);
  }

  void draw_list(Canvas& canvas, double x, double y) const {
    const double cells = x + label_width;
    canvas.text({x, y + list_head - 14}, "problem", normal, ink, Anchor::start, false);
    canvas.text({x + young_at, y + list_head - 14}, "E (Pa)", small, ink, Anchor::start, false);
    canvas.text({x + ratio_at, y + list_head - 14}, "ratio", small, ink, Anchor::start, false);
    canvas.text({x + step_at, y + list_head - 14}, "h (s)", small, ink, Anchor::start, false);
    for (std::size_t c = 0; c < columns_.size(); ++c)
      canvas.text({cells + (static_cast<double>(c) + 0.5) * list_cell - small / 2, y + list_head - 6},
                  columns_[c].first, small, ink, Anchor::start, true);
    for (std::size_t c = 0; c < columns_.size();) {
      std::size_t end = c;
      while (end < columns_.size() && columns_[end].second == columns_[c].second) ++end;
      const double from = cells + static_cast<double>(c) * list_cell,
                   to = cells + static_cast<double>(end) * list_cell;
      canvas.text({(from + to) / 2, y - 10}, columns_[c].second, small, ink, Anchor::middle, false);
      canvas.lines({{{from + 3, y + 6}, {to - 3, y + 6}}}, 1, line_colour);
      c = end;
    }
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const Row& row = rows_[r];
      const double top = y + list_head + static_cast<double>(r) * list_row,
                   text = top + (list_row - small) / 2;
      canvas.lines({{{x, top}, {cells, top}}}, 1, line_colour);
      canvas.text({x, text}, row.name, small, ink, Anchor::start, false);
      canvas.text({x + young_at, text}, young_text(row.young), small, ink, Anchor::start, false);
      canvas.text({x + ratio_at, text}, fmt::format("{:g}", row.poisson), small, ink, Anchor::start, false);
      canvas.text({x + step_at, text}, power(row.time_step), small, ink, Anchor::start, false);
      for (std::size_t c = 0; c < columns_.size(); ++c)
        if (const auto found = at_.find({row, columns_[c]}); found != at_.end())
          draw_cell(canvas, *found->second, cells + static_cast<double>(c) * list_cell, top, list_cell,
                    list_row);
    }
  }

  const StabilityReport& report_;
  std::vector<Column> columns_;
  std::vector<std::string> methods_, backends_;
  std::vector<double> youngs_, steps_; ///< of the maps, increasing
  std::vector<Row> rows_;              ///< of the list, in the order of the sweep
  std::map<std::pair<Row, Column>, const StabilityCell*> at_;
  double list_left_ = 0, width_ = 0, height_ = 0;
};

} // namespace

void write_stability_map(const StabilityReport& report, const std::filesystem::path& folder) {
  const Map map(report);
  SvgCanvas svg(map.width(), map.height());
  map.draw(svg);
  write_text_file(folder / "stability.svg", svg.finish());
  RasterCanvas raster(map.width(), map.height());
  map.draw(raster);
  write_png(raster.image, folder / "stability.png");
}

} // namespace pliant
