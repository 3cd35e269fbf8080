// pliant converge: error against run time.
#include "engine/cli/commands.h"
#include "engine/report/converge.h"
#include "engine/report/converge_run.h"
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
  unsigned at = 0, frames = 0;
  bool run = false;
};

/// Makes the folder and the folders above it. Throws Error(input_output).
void make_folder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw Error(ExitCode::input_output, "--out " + folder + ": " + error.message());
}

template <class Report>
void hand_over(const Options& options, const Report& report, const std::vector<std::filesystem::path>& files,
               nlohmann::json (*json)(const Report&), std::string (*text)(const Report&)) {
  for (const std::filesystem::path& file : files) notice("wrote " + file.string());
  if (options.json.wanted()) options.json.write(json(report).dump(2));
  if (options.json.target() != "-") std::fputs(text(report).c_str(), stdout);
}

ExitCode whole_run(Options& options, const Scene& scene, bool frames_given) {
  CurveOptions curve;
  if (frames_given) curve.frames = options.frames;
  const std::vector<std::string>& backends = options.converge.backends;
  if (backends.size() > 1) throw Error(ExitCode::usage, "--run runs on one backend: name one with --backend");
  curve.device = options.device.request();
  curve.device.backend = backends.empty() ? "openmp" : backends.front();
  curve.say = notice;
  const CurveReport report = work_precision(scene, curve);
  hand_over(options, report, write_curve(report, options.out), curve_json, curve_text);
  return ExitCode::good;
}

ExitCode converge(Options& options, bool at_given, bool frames_given) {
  if (at_given) options.converge.at = options.at;
  options.converge.threads = options.device.threads;
  options.converge.say = notice;
  const Scene scene = read_scene(options.scene.named(options.json), options.scene.overrides);
  if (options.run && (at_given || !options.converge.only.empty()))
    throw Error(ExitCode::usage,
                "--run takes the scene's own solver over the whole scene: without --at and --only; "
                "--set solver.method=NAME chooses another");
  if (!options.run && frames_given) throw Error(ExitCode::usage, "--frames goes with --run");
  make_folder(options.out);
  if (options.run) return whole_run(options, scene, frames_given);
  const ConvergeReport report = converge_step(scene, options.converge);
  hand_over(options, report, write_converge(report, options.out), converge_json, converge_text);
  return ExitCode::good;
}

} // namespace

void add_converge(CLI::App& program, Action& action) {
  CLI::App* command = program.add_subcommand(
      "converge", "error against run time: each solver on each backend, from the same state of a scene");
  const auto options = std::make_shared<Options>();
  add_scene(*command, options->scene);
  CLI::Option* at =
      command
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
  command
      ->add_option("--backend", options->converge.backends,
                   "these backends: openmp, gl or gl:N; all unless given")
      ->type_name("NAME,...")
      ->delimiter(',');
  add_threads(*command, options->device);
  command->add_flag("--run", options->run,
                    "the whole scene instead of one step: what tolerances and time steps cost and buy");
  CLI::Option* frames =
      command->add_option("--frames", options->frames, "of --run; as many as the time allows unless given")
          ->type_name("N")
          ->check(CLI::Range(1u, 100'000u).description(""));
  add_precision(*command, options->device);
  command->add_option("--seconds", options->converge.seconds, "of run time, after which a solver is given up")
      ->capture_default_str()
      ->type_name("S")
      ->check(CLI::Range(0.01, 600.0).description(""));
  add_json(*command, options->json, "print converge.json too, or write it to FILE");
  command->footer(
      R"(Every solver starts from the same state and first guess. Its position, residual and energy are compared with a
converged reference in double, outside the clock; a second start confirms the reference.
Examples:
  pliant converge examples/beam.toml --out out/beam-converge
  pliant converge examples/bunny.toml --at 0 --only newton,chebyshev --backend openmp
  pliant converge examples/beam.toml --run --frames 10)");
  command->callback([&action, options, at, frames] {
    action = [options, at, frames] { return converge(*options, at->count() > 0, frames->count() > 0); };
  });
}

} // namespace pliant::cli
