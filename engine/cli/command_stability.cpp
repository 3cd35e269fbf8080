// pliant stability: the stiff and extreme sweep.
#include "engine/cli/commands.h"
#include "engine/io/folder.h"
#include "engine/report/stability.h"
#include "engine/scene/scene_parse.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

namespace pliant::cli {

namespace {

struct Options {
  SceneChoice scene;
  JsonChoice json;
  std::string out;
  StabilityOptions sweep;
};

ExitCode stability(Options& options, bool minutes_given) {
  StabilityOptions& sweep = options.sweep;
  sweep.say = notice;
  const Scene scene = read_scene(options.scene.named(options.json), options.scene.overrides);
  if (sweep.full && !minutes_given) sweep.minutes = 0;
  const std::filesystem::path folder = options.out.empty()
                                           ? std::filesystem::path("out") / (scene.name + "-stability")
                                           : std::filesystem::path(options.out);
  prepare_output_folder(folder);
  const StabilityReport report = sweep_stability(scene, sweep);
  write_stability(report, folder);
  if (options.json.wanted())
    options.json.write(stability_json(report).dump(2));
  else
    std::fputs(stability_text(report).c_str(), stdout);
  notice("stability.csv, stability.json, stability.svg and stability.png are in " + folder.string());
  return report.good() ? ExitCode::good : ExitCode::diverged;
}

} // namespace

void add_stability(CLI::App& program, Action& action) {
  CLI::App* command = program.add_subcommand(
      "stability", "the stiff and extreme sweep: what stays finite and bounded, and what comes back");
  const auto options = std::make_shared<Options>();
  StabilityOptions& sweep = options->sweep;
  add_scene(*command, options->scene);
  command
      ->add_option("--out", options->out,
                   "folder for CSV, JSON and the map; out/<name>-stability unless given")
      ->type_name("FOLDER");
  command->add_option("--methods", sweep.methods, "solvers to judge")
      ->capture_default_str()
      ->type_name("NAME,...")
      ->delimiter(',');
  command
      ->add_option("--backend", sweep.backends,
                   "openmp-float, openmp-double or gl:N; may be repeated; all that are usable unless given")
      ->type_name("NAME")
      ->expected(1)
      ->take_all();
  command->add_option("--only", sweep.only, "problems whose name contains this")->type_name("TEXT");
  const auto count = [&](const char* name, auto& value, const char* meaning, unsigned least, unsigned most) {
    command->add_option(name, value, meaning)
        ->capture_default_str()
        ->type_name("N")
        ->check(CLI::Range(least, most).description(""));
  };
  count("--particles", sweep.particles, "of the body, at most: its spacing grows until they suffice", 8,
        100'000);
  count("--steps", sweep.steps, "of each cell", 2, 1'000'000);
  count("--iterations", sweep.iterations, "a cap for each step", 1, 1'000'000);
  CLI::Option* minutes =
      command->add_option("--minutes", sweep.minutes, "no cell begins after so long; 0: no limit")
          ->capture_default_str()
          ->type_name("M")
          ->check(CLI::NonNegativeNumber.description(""));
  count("--jobs", sweep.jobs, "CPU cells at a time; 0: as many as there are processors", 0, 4096);
  command->add_flag("--full", sweep.full,
                    "every problem on software GL too, and 1e5 steps at rest; no time limit");
  add_json(*command, options->json, "print JSON, or write it to FILE");
  command->footer(R"(Ends with 0 where every cell stays finite and bounded, else with 4.
Examples:
  pliant stability examples/beam.toml
  pliant stability drop.toml --only flattened --methods newton --backend openmp-double)");
  command->callback([&action, options, minutes] {
    action = [options, minutes] { return stability(*options, minutes->count() > 0); };
  });
}

} // namespace pliant::cli
