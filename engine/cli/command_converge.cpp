// pliant converge: error against run time.
#include "engine/cli/commands.h"
#include "engine/report/converge.h"
#include "engine/scene/scene_parse.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace pliant::cli {

namespace {

struct Options {
  SceneChoice scene;
  DeviceChoice device;
  JsonChoice json;
  ConvergeOptions converge;
  std::string out = ".";
  unsigned at = 0;
};

ExitCode converge(Options& options, bool at_given) {
  if (at_given) options.converge.at = options.at;
  options.converge.threads = options.device.threads;
  options.converge.say = notice;
  const Scene scene = read_scene(options.scene.named(options.json), options.scene.overrides);
  std::filesystem::create_directories(options.out);
  const ConvergeReport report = converge_step(scene, options.converge);
  for (const std::filesystem::path& file : write_converge(report, options.out))
    notice("wrote " + file.string());
  if (options.json.wanted())
    options.json.write(converge_json(report).dump(2));
  else
    std::fputs(converge_text(report).c_str(), stdout);
  return ExitCode::good;
}

} // namespace

void add_converge(CLI::App& program, Action& action) {
  CLI::App* command = program.add_subcommand(
      "converge", "error against run time: each solver on each backend, from the same state of a scene");
  const auto options = std::make_shared<Options>();
  add_scene(*command, options->scene);
  CLI::Option* at = command
                        ->add_option("--at", options->at,
                                     "watch the step after STEP steps; unless given, the hardest of the first 60")
                        ->type_name("STEP")
                        ->check(CLI::Range(0u, 100'000'000u).description(""));
  command->add_option("--out", options->out, "folder for converge.csv, .json, .svg and .png; made if need be")
      ->capture_default_str()
      ->type_name("FOLDER");
  command
      ->add_option("--only", options->converge.only,
                   "these solvers: chebyshev, jacobi, position, direct, lbfgs, newton, newton+diagonal, ...")
      ->type_name("NAME,...")
      ->delimiter(',');
  command->add_option("--backend", options->converge.backends, "these backends: openmp, gl or gl:N; all unless given")
      ->type_name("NAME,...")
      ->delimiter(',');
  add_threads(*command, options->device);
  command->add_option("--seconds", options->converge.seconds, "of run time, after which a solver is given up")
      ->capture_default_str()
      ->type_name("S")
      ->check(CLI::Range(0.01, 600.0).description(""));
  add_json(*command, options->json, "print converge.json too, or write it to FILE");
  command->footer(R"(Every solver starts from the same state and first guess. Its position, residual and energy are compared with a
converged reference in double, outside the clock; a second start confirms the reference.
Examples:
  pliant converge examples/beam.toml --out out/beam-converge
  pliant converge examples/bunny.toml --at 0 --only newton,chebyshev --backend openmp)");
  command->callback([&action, options, at] {
    action = [options, at] { return converge(*options, at->count() > 0); };
  });
}

} // namespace pliant::cli
