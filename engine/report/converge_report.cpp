// What the race within one step showed, for people, for programs and as pictures.
#include "engine/report/converge.h"

#include "engine/io/folder.h"
#include "engine/render/plot.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace pliant {

namespace {

struct Kind {
  const char *key, *name;
  double ConvergePoint::*error;
};
constexpr Kind position{"position", "position error (rms, spacings)", &ConvergePoint::position_rms};
constexpr Kind largest{"position_max", "largest position error (spacings)", &ConvergePoint::position_max};
constexpr Kind residual{"residual", "residual of Eq. 12 (of the start's)", &ConvergePoint::residual};
constexpr Kind energy{"energy", "energy error of Eq. 25 (of the start's)", &ConvergePoint::energy_error};

bool has_energy(const ConvergeReport& r) {
  return std::isfinite(r.reference.potential);
}

/// At most four digits.
std::string milliseconds(const ConvergeSeries& series, double ConvergePoint::*error, double limit) {
  const std::optional<double> ms = time_to(series, error, limit);
  if (!ms) return "never";
  if (!series.points.empty() && *ms == series.points.front().ms) return "start";
  return *ms >= 999.5 ? fmt::format("{:.0f}", *ms) : fmt::format("{:.3g}", *ms);
}

std::string row_name(const ConvergeSeries& series) {
  return fmt::format("  {:<18} {:<14}", series.variant(), series.place());
}

template <class Limits> std::string table(const ConvergeReport& r, const Kind& kind, const Limits& limits) {
  std::string text = fmt::format("\nms to {}\n  {:<33}", kind.name, "");
  for (const double limit : limits) text += fmt::format("{:>9}", fmt::format("{:.0e}", limit));
  text += "\n";
  for (const ConvergeSeries& series : r.series) {
    text += row_name(series);
    for (const double limit : limits) text += fmt::format("{:>9}", milliseconds(series, kind.error, limit));
    text += "\n";
  }
  return text;
}

nlohmann::json number(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

template <class Limits>
nlohmann::json times_json(const ConvergeSeries& series, double ConvergePoint::*error, const Limits& limits) {
  nlohmann::json times = nlohmann::json::object();
  for (const double limit : limits) {
    const std::optional<double> ms = time_to(series, error, limit);
    times[fmt::format("1e-{}", std::lround(-std::log10(limit)))] =
        ms ? nlohmann::json(*ms) : nlohmann::json();
  }
  return times;
}

// A colour a method, a dash and a marker a device.
Plot plot_of(const ConvergeReport& r, const Kind& kind, const std::string& title, bool by_time = true) {
  Plot plot;
  plot.title = fmt::format("{}: {}, step {}, {} particles, eta {:.3g}", r.scene, title, r.step + 1,
                           r.particles, r.stiffness_number);
  plot.x_label = by_time ? "run time of the step (ms)" : "iterations (evaluations and products)";
  plot.y_label = kind.name;
  plot.log_x = plot.log_y = true;
  plot.width = 1200, plot.height = 720;
  constexpr Colour colours[] = {{0, 114, 178},  {213, 94, 0}, {0, 158, 115}, {204, 121, 167}, {230, 159, 0},
                                {86, 180, 233}, {0, 0, 0},    {140, 86, 75}, {127, 127, 0}};
  std::vector<std::string> variants, places;
  const auto index = [](std::vector<std::string>& names, const std::string& name) {
    const auto at = std::find(names.begin(), names.end(), name);
    if (at != names.end()) return static_cast<std::size_t>(at - names.begin());
    names.push_back(name);
    return names.size() - 1;
  };
  for (const ConvergeSeries& one : r.series) {
    Series curve;
    const std::size_t variant = index(variants, one.variant()), place = index(places, one.place());
    curve.style.colour = colours[variant % std::size(colours)];
    curve.style.shape = static_cast<unsigned>(place);
    curve.style.dashed = static_cast<unsigned>(place);
    for (const ConvergePoint& point : one.points) {
      if (point.iteration == 0) continue; // the same for all
      curve.x.push_back(by_time ? point.ms : point.iteration);
      curve.y.push_back(point.*kind.error);
    }
    plot.series.push_back(std::move(curve));
  }
  const auto key = [&plot](const std::string& label, const SeriesStyle& style) {
    Series entry;
    entry.label = label, entry.style = style;
    plot.series.push_back(std::move(entry));
  };
  for (std::size_t v = 0; v < variants.size(); ++v)
    key(variants[v], {.colour = colours[v % std::size(colours)], .shape = 0u, .markers = false});
  for (std::size_t p = 0; p < places.size(); ++p)
    key(places[p], {.colour = Colour{110, 110, 110},
                    .shape = static_cast<unsigned>(p),
                    .dashed = static_cast<unsigned>(p)});
  return plot;
}

} // namespace

std::string converge_text(const ConvergeReport& r) {
  const ConvergeReference& ref = r.reference;
  std::string text = fmt::format(
      "scene {}: {} particles, {} bonds, stiffness number {:.4g}, step {} of {:.4g} s\n"
      "{}, {} threads; {}\n"
      "reference: {} in double, {} iterations, {:.2f} s, to {:.1e} of the start's residual ({:.3g} sqrt(N "
      "m))\n"
      "second start ({}): ends {:.1e} spacings away (largest; rms {:.1e}): {}\n"
      "first guess: {:.3g} spacings rms, {:.3g} largest, away from it\n",
      r.scene, r.particles, r.bonds, r.stiffness_number, r.step + 1, r.time_step, r.processor, r.threads,
      r.build, ref.method, ref.iterations, ref.seconds, ref.residual, r.residual_at_start, ref.second_start,
      ref.agree_max, ref.agree_rms,
      ref.confirmed()        ? "confirmed"
      : ref.agree_max > 1e-2 ? "NOT confirmed, another minimum: position errors are to the first of the two"
                             : "NOT confirmed: position errors below this mean nothing",
      ref.first_rms, ref.first_max);
  if (has_energy(r))
    text +=
        fmt::format("energy: {:.6g} J at the start, {:.6g} J at the end; errors below {:.0e} are rounding\n",
                    ref.first_potential, ref.potential, ref.energy_floor);
  else
    text += "energy: friction or the law has no potential, so there is no energy error\n";
  if (ref.first_rms < converge_errors.back())
    text += "The first guess is the answer: nothing to compare; name another step with --at\n";
  text += table(r, position, converge_errors);
  text += table(r, largest, std::array{1e-1, 1e-2, 1e-3});
  text += table(r, residual, converge_errors);
  if (has_energy(r)) text += table(r, energy, converge_energy_errors);
  text += fmt::format("\n  {:<33}{:>10}{:>12}{:>10}{:>8}  {}\n", "", "set-up ms", "iterations", "ms each",
                      "passes", "ended at");
  for (const ConvergeSeries& series : r.series) {
    const ConvergePoint& last = series.points.back();
    text +=
        row_name(series) + fmt::format("{:>10.4g}{:>12}{:>10.3g}{:>8}  {}{}\n", series.setup_ms,
                                       last.iteration, last.ms / std::max(last.iteration, 1u), series.passes,
                                       series.end, series.software ? " (software GL)" : "");
  }
  for (const std::string& line : r.left_out) text += fmt::format("left out: {}\n", line);
  return text;
}

nlohmann::json converge_json(const ConvergeReport& r) {
  nlohmann::json all = nlohmann::json::array();
  for (const ConvergeSeries& series : r.series) {
    nlohmann::json points = nlohmann::json::array();
    for (const ConvergePoint& point : series.points)
      points.push_back({{"iteration", point.iteration},
                        {"ms", point.ms},
                        {"residual", number(point.residual)},
                        {"energy_error", number(point.energy_error)},
                        {"position_rms", number(point.position_rms)},
                        {"position_max", number(point.position_max)}});
    all.push_back({{"method", series.method},
                   {"preconditioner",
                    series.preconditioner.empty() ? nlohmann::json() : nlohmann::json(series.preconditioner)},
                   {"backend", series.backend},
                   {"device", series.device},
                   {"software", series.software},
                   {"precision", series.precision},
                   {"setup_ms", series.setup_ms},
                   {"passes", series.passes},
                   {"end", series.end},
                   {"points", points},
                   {"time_to",
                    {{"residual", times_json(series, residual.error, converge_errors)},
                     {"energy", times_json(series, energy.error, converge_energy_errors)},
                     {"position", times_json(series, position.error, converge_errors)},
                     {"position_max", times_json(series, largest.error, converge_errors)}}}});
  }
  const ConvergeReference& ref = r.reference;
  return {{"scene", r.scene},
          {"particles", r.particles},
          {"bonds", r.bonds},
          {"stiffness_number", r.stiffness_number},
          {"spacing", r.spacing},
          {"time_step", r.time_step},
          {"step", r.step},
          {"processor", r.processor},
          {"threads", r.threads},
          {"build", r.build},
          {"reference",
           {{"method", ref.method},
            {"iterations", ref.iterations},
            {"seconds", ref.seconds},
            {"residual", number(ref.residual)},
            {"second_start", ref.second_start},
            {"agree_rms", number(ref.agree_rms)},
            {"agree_max", number(ref.agree_max)},
            {"confirmed", ref.confirmed()},
            {"potential", number(ref.potential)},
            {"first_potential", number(ref.first_potential)},
            {"energy_floor", number(ref.energy_floor)},
            {"first_position_rms", number(ref.first_rms)},
            {"first_position_max", number(ref.first_max)}}},
          {"series", all},
          {"left_out", r.left_out},
          {"seconds", r.seconds}};
}

std::string converge_csv(const ConvergeReport& r) {
  std::string text = "method,preconditioner,backend,precision,iteration,ms,residual,energy_error,position_"
                     "rms,position_max\n";
  for (const ConvergeSeries& series : r.series)
    for (const ConvergePoint& point : series.points)
      text += fmt::format("{},{},{},{},{},{:.6g},{:.6e},{:.6e},{:.6e},{:.6e}\n", series.method,
                          series.preconditioner, series.backend, series.precision, point.iteration, point.ms,
                          point.residual, point.energy_error, point.position_rms, point.position_max);
  return text;
}

std::vector<std::filesystem::path> write_converge(const ConvergeReport& r,
                                                  const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  const auto add = [&](const char* name) { return files.emplace_back(folder / name); };
  write_text_file(add("converge.csv"), converge_csv(r));
  write_text_file(add("converge.json"), converge_json(r).dump(2) + "\n");
  const Plot headline = plot_of(r, position, "position error against run time"),
             second = plot_of(r, residual, "residual against run time");
  write_svg(headline, add("converge.svg"));
  write_png(headline, add("converge.png"));
  write_svg(second, add("converge-residual.svg"));
  write_png(second, add("converge-residual.png"));
  if (!has_energy(r)) return files;
  const Plot third = plot_of(r, energy, "energy error against run time");
  write_svg(third, add("converge-energy.svg"));
  write_png(third, add("converge-energy.png"));
  const Plot fourth = plot_of(r, energy, "energy error against iterations", false); // their Fig. 7
  write_svg(fourth, add("converge-energy-iterations.svg"));
  write_png(fourth, add("converge-energy-iterations.png"));
  return files;
}

} // namespace pliant
