// What the work-precision runs showed, for people, for programs and as a picture.
#include "engine/report/converge_run.h"

#include "engine/io/folder.h"
#include "engine/render/plot.h"

#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace pliant {

namespace {

std::string setting(const CurvePoint& point) {
  return point.budget ? fmt::format("{} iterations", point.budget)
                      : fmt::format("tolerance {:.0e}", point.tolerance);
}

nlohmann::json number(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

Plot plot_of(const CurveReport& r) {
  Plot plot;
  plot.title = fmt::format("{}: position error after {:.3g} s against run time, {}, {} particles, {}",
                           r.scene, r.duration, r.method, r.particles, r.precision);
  plot.x_label = "run time of a frame (ms, median)";
  plot.y_label = "position error at the end (rms, spacings)";
  plot.log_x = plot.log_y = true;
  plot.width = 1200, plot.height = 720;
  constexpr Colour colours[] = {{0, 114, 178}, {213, 94, 0}, {0, 158, 115}, {204, 121, 167}};
  double fastest = 1e300, slowest = 0;
  for (const CurvePoint& point : r.points)
    fastest = std::min(fastest, point.ms), slowest = std::max(slowest, point.ms);
  for (std::size_t s = 0; s < r.steps.size(); ++s) {
    Series total, solver;
    total.label = fmt::format("step {:.4g} s, tolerances: total", r.steps[s].time_step);
    solver.label = fmt::format("step {:.4g} s, tolerances: solver's part", r.steps[s].time_step);
    total.style = {.colour = colours[s % 4], .shape = static_cast<unsigned>(s)};
    solver.style = {
        .colour = colours[s % 4], .shape = static_cast<unsigned>(s), .markers = false, .dashed = 1};
    for (const CurvePoint& point : r.points) {
      if (point.budget > 0 || std::abs(point.time_step - r.steps[s].time_step) > 1e-9 * point.time_step)
        continue;
      total.x.push_back(point.ms), total.y.push_back(point.total_error);
      solver.x.push_back(point.ms), solver.y.push_back(point.solver_error);
    }
    plot.series.push_back(std::move(total));
    plot.series.push_back(std::move(solver));
  }
  Series budgets;
  budgets.label = fmt::format("step {:.4g} s, budgets: total", r.time_step);
  budgets.style = {.colour = Colour{0, 0, 0}, .shape = 5, .dashed = 2};
  for (const CurvePoint& point : r.points)
    if (point.budget > 0) budgets.x.push_back(point.ms), budgets.y.push_back(point.total_error);
  plot.series.push_back(std::move(budgets));
  if (r.space_error && !r.points.empty()) {
    Series space;
    space.label = "error of the spacing";
    space.x = {fastest, slowest}, space.y = {*r.space_error, *r.space_error};
    space.style = {.colour = Colour{110, 110, 110}, .shape = 0u, .markers = false, .dashed = 3};
    plot.series.push_back(std::move(space));
  }
  return plot;
}

} // namespace

std::string curve_text(const CurveReport& r) {
  std::string text =
      fmt::format("scene {}: {} particles, {} bonds, stiffness number {:.4g}; {} frames, {:.4g} s\n"
                  "{} on {}, {}, {} threads\n\n",
                  r.scene, r.particles, r.bonds, r.stiffness_number, r.frames, r.duration, r.method, r.device,
                  r.precision, r.threads);
  text += fmt::format("  {:<12}{:<18}{:>12}{:>12}{:>10}{:>12}{:>12}{:>12}\n", "step (s)", "", "iterations",
                      "ms a frame", "95 %", "solver", "total rms", "largest");
  for (const CurvePoint& p : r.points)
    text +=
        fmt::format("  {:<12.4g}{:<18}{:>12.4g}{:>12.4g}{:>10.4g}{:>12.2e}{:>12.2e}{:>12.2e}\n", p.time_step,
                    setting(p), p.iterations, p.ms, p.ms_worst, p.solver_error, p.total_error, p.total_max);
  text += fmt::format(
      "Errors in spacings at the end. Solver: to the tight run of the same step. Total: to the tight "
      "run with steps of {:.4g} s.\n\n",
      r.reference_step);
  text += "Split of the error (spacings, rms)\n";
  for (const CurveReport::Step& step : r.steps)
    text +=
        fmt::format("  time, step {:.4g} s: {:.2e}{}\n", step.time_step, step.time_error,
                    std::abs(step.time_step - r.time_step) < 1e-9 * r.time_step ? "   (the scene's)" : "");
  text += r.space_error ? fmt::format("  space, spacing {:.4g} m: {:.2e}   ({})\n", r.spacing, *r.space_error,
                                      r.space_note)
                        : fmt::format("  space: {}\n", r.space_note);
  text += "  model: left out, there is no closed form for this scene\n";
  if (r.enough)
    text += fmt::format(
        "Beyond {} iterations a step the solver's error is below that of {}: more are wasted at this "
        "step and spacing.\n",
        *r.enough, r.space_error && *r.space_error > r.time_error() ? "the spacing" : "the step");
  else
    text += "No budget tried brings the solver's error below that of the step: more iterations, a lower "
            "tolerance or "
            "another solver pay.\n";
  if (r.pick) {
    const CurvePoint& p = r.points[*r.pick];
    text += fmt::format(
        "Pick solver.tolerance = {:.0e} and simulation.time_step = {:.4g}: {:.3g} ms a frame, {:.2e} "
        "spacings after {:.3g} s.\n",
        p.tolerance, p.time_step, p.ms, p.total_error, r.duration);
  }
  for (const std::string& line : r.left_out) text += fmt::format("left out: {}\n", line);
  return text;
}

nlohmann::json curve_json(const CurveReport& r) {
  nlohmann::json points = nlohmann::json::array(), steps = nlohmann::json::array();
  for (const CurvePoint& p : r.points)
    points.push_back({{"time_step", p.time_step},
                      {"tolerance", p.budget ? nlohmann::json() : nlohmann::json(p.tolerance)},
                      {"budget", p.budget ? nlohmann::json(p.budget) : nlohmann::json()},
                      {"iterations", p.iterations},
                      {"ms_frame", p.ms},
                      {"ms_frame_p95", p.ms_worst},
                      {"solver_error", number(p.solver_error)},
                      {"total_error", number(p.total_error)},
                      {"total_max", number(p.total_max)}});
  for (const CurveReport::Step& step : r.steps)
    steps.push_back({{"time_step", step.time_step},
                     {"time_error", number(step.time_error)},
                     {"tight_ms_frame", step.ms}});
  nlohmann::json pick;
  if (r.pick) pick = {{"tolerance", r.points[*r.pick].tolerance}, {"time_step", r.points[*r.pick].time_step}};
  return {{"scene", r.scene},
          {"particles", r.particles},
          {"bonds", r.bonds},
          {"stiffness_number", r.stiffness_number},
          {"spacing", r.spacing},
          {"time_step", r.time_step},
          {"frames", r.frames},
          {"duration", r.duration},
          {"method", r.method},
          {"device", r.device},
          {"precision", r.precision},
          {"threads", r.threads},
          {"reference_step", r.reference_step},
          {"points", points},
          {"split",
           {{"time", steps},
            {"space", r.space_error ? nlohmann::json(*r.space_error) : nlohmann::json()},
            {"space_note", r.space_note},
            {"model", nlohmann::json()}}},
          {"enough_iterations", r.enough ? nlohmann::json(*r.enough) : nlohmann::json()},
          {"pick", pick},
          {"left_out", r.left_out},
          {"seconds", r.seconds}};
}

std::string curve_csv(const CurveReport& r) {
  std::string text =
      "time_step,tolerance,budget,iterations,ms_frame,ms_frame_p95,solver_error,total_error,total_max\n";
  for (const CurvePoint& p : r.points)
    text += fmt::format("{:.9g},{},{},{},{:.6g},{:.6g},{:.6e},{:.6e},{:.6e}\n", p.time_step,
                        p.budget ? "" : fmt::format("{:g}", p.tolerance),
                        p.budget ? fmt::format("{}", p.budget) : "", p.iterations, p.ms, p.ms_worst,
                        p.solver_error, p.total_error, p.total_max);
  return text;
}

std::vector<std::filesystem::path> write_curve(const CurveReport& r, const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  const auto add = [&](const char* name) { return files.emplace_back(folder / name); };
  write_text_file(add("converge-run.csv"), curve_csv(r));
  write_text_file(add("converge-run.json"), curve_json(r).dump(2) + "\n");
  const Plot plot = plot_of(r);
  write_svg(plot, add("converge-run.svg"));
  write_png(plot, add("converge-run.png"));
  return files;
}

} // namespace pliant
