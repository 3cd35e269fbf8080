// Figures 1 and 4 of He, Wang and Wu (2018), each method beside Pliant.
#include "bench/baselines/trial.h"

#include "engine/core/error.h"
#include "engine/render/plot.h"
#include "engine/scene/scene_parse.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <future>
#include <thread>

namespace pliant::bench {
namespace {

std::string seconds(double value) {
  return std::isfinite(value) ? fmt::format("{:.3g} ms", 1e3 * value) : "none";
}

void write_plot(const Plot& plot, const std::filesystem::path& folder, const std::string& name) {
  write_png(plot, folder / (name + ".png"));
  write_svg(plot, folder / (name + ".svg"));
}

struct Order {
  std::string method;
  TrialSettings settings;
};

/// Trials in the order given, as many at a time as there are processors.
std::vector<Trial> run_all(const Scene& scene, const Model& model, const std::vector<Order>& orders) {
  const std::size_t at_once = std::max(std::thread::hardware_concurrency(), 1u);
  std::vector<std::future<Trial>> running(orders.size());
  std::vector<Trial> done;
  for (std::size_t next = 0; done.size() < orders.size();) {
    for (; next < orders.size() && next < done.size() + at_once; ++next)
      running[next] = std::async(std::launch::async, [&scene, &model, &order = orders[next]] {
        return run_trial(order.method, scene, model, order.settings);
      });
    done.push_back(running[done.size()].get());
  }
  return done;
}

// The beam is let down with a damping near critical for its first mode (10 rad/s), the same for every method,
// so that the depth is the equilibrium's and no integrator's damping shows.
void figure1(const std::filesystem::path& examples, const std::filesystem::path& folder) {
  constexpr double steps[] = {0.0004, 0.001, 0.004, 0.016};
  const Scene scene = read_scene(examples / "beam.toml", {"solver.tolerance=1e-4"});
  const Model model = assemble(scene);
  TrialSettings settings;
  settings.seconds = 0.96;
  settings.damping = 20;
  Plot plot;
  plot.title = "Fig. 1: how far the tip of a beam sinks";
  plot.x_label = "time step, s";
  plot.y_label = "depth at rest, m";
  plot.log_x = true;
  std::vector<Order> orders;
  for (const char* method : method_names())
    for (const double h : steps) {
      settings.time_step = h;
      orders.push_back({method, settings});
    }
  const std::vector<Trial> all = run_all(scene, model, orders);
  std::size_t next = 0;
  fmt::print("Fig. 1, {} particles: depth of the tip at rest, m, by time step\n\n", model.count());
  fmt::print("| method | stable below |");
  for (const double h : steps) fmt::print(" {:g} s |", h);
  fmt::print("\n|---|---|---|---|---|---|\n");
  for (const char* method : method_names()) {
    Series series;
    series.label = method;
    std::string row;
    double stable = 0;
    for (const double h : steps) {
      const Trial& trial = all[next++];
      stable = trial.stable_step;
      row += trial.diverged ? fmt::format(" diverged at {:.2g} s |", trial.diverged_at)
                            : fmt::format(" {:.4f} |", trial.samples.back().tip_depth);
      series.x.push_back(h);
      series.y.push_back(trial.diverged ? std::nan("") : trial.samples.back().tip_depth);
    }
    fmt::print("| {} | {} |{}\n", method, seconds(stable), row);
    plot.series.push_back(series);
  }
  fmt::print("\n");
  write_csv(all, folder / "figure1.csv");
  write_plot(plot, folder, "figure1");
}

// Explicit methods take their own stable step; all are damped alike, or those that conserve energy would
// never come to rest.
void figure4(const std::filesystem::path& examples, const std::filesystem::path& folder, double spacing) {
  const Scene scene =
      read_scene(examples / "armadillo.toml", {fmt::format("simulation.spacing={:g}", spacing)});
  const Model model = assemble(scene);
  TrialSettings settings;
  settings.seconds = 2;
  settings.damping = 10;
  settings.every = 1.0 / 30;
  Plot plot;
  plot.title = "Fig. 4: an armadillo with inverted regions";
  plot.x_label = "time, s";
  plot.y_label = "rms distance to the rest shape, spacings";
  plot.log_y = true;
  std::vector<Order> orders;
  for (const char* method : method_names()) orders.push_back({method, settings});
  const std::vector<Trial> all = run_all(scene, model, orders);
  fmt::print("Fig. 4, {} particles, 2 s: an armadillo with inverted regions\n\n", model.count());
  fmt::print(
      "| method | time step | det F > 0 at the start | at the end | rms distance at the start | at the end, "
      "spacings | CPU, s |\n|---|---|---|---|---|---|---|\n");
  for (const Trial& trial : all) {
    const Sample &first = trial.samples.front(), &last = trial.samples.back();
    fmt::print("| {} | {} | {:.4f} | {} | {:.3f} | {} | {:.1f} |\n", trial.method, seconds(trial.time_step),
               first.upright, trial.diverged ? "diverged" : fmt::format("{:.4f}", last.upright),
               first.distance, trial.diverged ? "diverged" : fmt::format("{:.4f}", last.distance),
               trial.cpu_seconds);
    Series series;
    series.label = trial.method;
    for (const Sample& s : trial.samples) series.x.push_back(s.time), series.y.push_back(s.distance);
    plot.series.push_back(series);
  }
  fmt::print("\n");
  write_csv(all, folder / "figure4.csv");
  write_plot(plot, folder, "figure4");
}

} // namespace

void draw_figures(const std::filesystem::path& examples, const std::filesystem::path& folder,
                  double spacing) {
  std::error_code failure;
  std::filesystem::create_directories(folder, failure);
  if (failure) throw Error(ExitCode::input_output, folder.string() + ": " + failure.message());
  figure1(examples, folder);
  std::fflush(stdout);
  figure4(examples, folder, spacing);
}

} // namespace pliant::bench
