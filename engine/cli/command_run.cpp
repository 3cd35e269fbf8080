// pliant run: simulate, draw, store.
#include "engine/cli/commands.h"
#include "engine/report/run.h"

#include <CLI/CLI.hpp>

namespace pliant::cli {

namespace {

struct Options {
  SceneChoice scene;
  DeviceChoice device;
  JsonChoice json;
  RunOptions run;
  std::string out;
  unsigned frames = 0;
  bool no_render = false, replay = false;
};

ExitCode run(Options& options, bool frames_given) {
  RunOptions& run = options.run;
  run.scene = options.scene.named(options.json);
  run.out = options.out;
  run.overrides = options.scene.overrides;
  run.device = options.device.request();
  run.device.replay = options.replay;
  if (frames_given) run.frames = options.frames;
  run.render = !options.no_render;
  run.json = options.json.target();
  if (run.video && !run.render)
    throw Error(ExitCode::usage,
                "--video makes a film from the pictures, which --no-render leaves out: drop one of them");
  return run_scene(run);
}

} // namespace

void add_run(CLI::App& program, Action& action) {
  CLI::App* command =
      program.add_subcommand("run", "simulate a scene; write frames, pictures and statistics");
  const auto options = std::make_shared<Options>();
  add_scene(*command, options->scene);
  command
      ->add_option("--out", options->out,
                   "folder to write, new or empty unless with --resume; out/<name of the scene> unless given")
      ->type_name("FOLDER");
  add_backend(*command, options->device);
  add_threads(*command, options->device);
  add_precision(*command, options->device);
  command->add_option("--solver", options->run.solver, "chebyshev or jacobi, instead of the scene's")
      ->type_name("NAME")
      ->check(CLI::IsMember({"auto", "chebyshev", "jacobi", "position", "direct", "lbfgs", "newton"})
                  .description(""));
  CLI::Option* frames = command->add_option("--frames", options->frames, "end after N frames past frame 0")
                            ->type_name("N")
                            ->check(CLI::Range(1u, 100'000'000u).description(""));
  command->add_flag("--resume", options->run.resume,
                    "go on from the last checkpoint in the folder, bit for bit; start anew if it has none");
  command->add_flag("--video", options->run.video, "make film.mp4 too (needs ffmpeg)");
  command->add_flag("--no-render", options->no_render, "no pictures; needs no GL device then");
  command
      ->add_option("--progress", options->run.progress, "auto, bar, plain, json or none; on standard error")
      ->capture_default_str()
      ->type_name("NAME")
      ->check(CLI::IsMember({"auto", "bar", "plain", "json", "none"}).description(""));
  add_json(*command, options->json, "print run.json too, or write it to FILE");
  command->add_flag("--replay", options->replay,
                    "debug: run each kernel on the CPU too and stop at the first that differs");
  command->footer(R"(Examples:
  pliant run drop.toml
  pliant run examples/beam.toml --out out/stiff --set materials.rubber.young=1e7 --frames 30
  pliant run examples/armadillo.toml --backend gl:0 --video
  pliant run drop.toml --resume)");
  command->callback([&action, options, frames] {
    action = [options, frames] { return run(*options, frames->count() > 0); };
  });
}

} // namespace pliant::cli
