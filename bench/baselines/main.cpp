// A scene by one of the methods that projective peridynamics is measured against, or by all of them.
//
//   build/bench/baselines examples/beam.toml --method mls --step 0.00025 --seconds 1 --csv mls.csv
//   build/bench/baselines --figures out/baselines
#include "bench/baselines/trial.h"

#include "engine/core/error.h"
#include "engine/scene/scene_parse.h"

#include <CLI/CLI.hpp>
#include <cmath>
#include <fmt/format.h>

using namespace pliant;
using namespace pliant::bench;

namespace {

std::string milliseconds(double value) {
  return std::isfinite(value) ? fmt::format("{:.3g}", 1e3 * value) : "-";
}

int run(int argc, char** argv) {
  CLI::App app("A scene by the methods that projective peridynamics is measured against.");
  std::string scene_file, method, csv, figures, examples = "examples";
  std::vector<std::string> overrides;
  TrialSettings settings;
  settings.seconds = 0;
  double spacing = 0.035;
  app.add_option("scene", scene_file, "scene file");
  const auto names = method_names();
  app.add_option("--method", method,
                 "mass-spring, shape-matching, explicit, mls or pliant; all of them by default")
      ->check(CLI::IsMember(std::vector<std::string>(names.begin(), names.end())));
  app.add_option("--seconds", settings.seconds, "time to simulate, s; the scene's by default")
      ->check(CLI::PositiveNumber);
  app.add_option("--step", settings.time_step,
                 "time step, s; the scene's by default, or a stable one where that is smaller")
      ->check(CLI::PositiveNumber);
  app.add_option("--damping", settings.damping, "decay of velocities, 1/s; none by default")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--csv", csv, "write samples to this file");
  app.add_option("--set", overrides, "key=value of the scene")->take_all();
  app.add_option("--figures", figures, "print Figs. 1 and 4 as tables and write them into this folder");
  app.add_option("--examples", examples, "folder of beam.toml and armadillo.toml, for --figures");
  app.add_option("--armadillo-spacing", spacing, "m, for --figures")->check(CLI::PositiveNumber);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(ExitCode::usage);
  }
  if (!figures.empty()) {
    draw_figures(examples, figures, spacing);
    return 0;
  }
  if (scene_file.empty()) throw Error(ExitCode::usage, "name a scene file, or give --figures FOLDER");
  const Scene scene = read_scene(scene_file, overrides);
  const Model model = assemble(scene);
  if (settings.seconds <= 0) settings.seconds = scene.simulation.end;
  settings.every = 1 / scene.output.fps;
  std::vector<Trial> trials;
  fmt::print("{:<15} {:>9} {:>9} {:>8} {:>11} {:>10} {:>10} {:>10} {:>8}\n", "method", "step ms", "limit ms",
             "time s", "tip depth m", "det F > 0", "rms spcgs", "speed m/s", "cpu s");
  for (const char* name : names) {
    if (!method.empty() && method != name) continue;
    trials.push_back(run_trial(name, scene, model, settings));
    const Trial& t = trials.back();
    const Sample& s = t.samples.back();
    fmt::print("{:<15} {:>9} {:>9} {:>8.4g} {:>11.5g} {:>10.5f} {:>10.5f} {:>10.4g} {:>8.2f}{}\n", t.method,
               milliseconds(t.time_step), milliseconds(t.stable_step), s.time, s.tip_depth, s.upright,
               s.distance, s.speed, t.cpu_seconds,
               t.diverged ? fmt::format("  diverged at {:.3g} s", t.diverged_at) : "");
    std::fflush(stdout);
  }
  if (!csv.empty()) write_csv(trials, csv);
  return 0;
}

} // namespace

int main(int argc, char** argv) try { return run(argc, argv); } catch (const Error& error) {
  fmt::print(stderr, "baselines: {}\n", error.what());
  return static_cast<int>(error.code());
}
