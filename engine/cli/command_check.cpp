// pliant check: is a scene sound, how large is it, how long will it take.
#include "engine/cli/commands.h"
#include "engine/report/check.h"
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
};

ExitCode check(Options& options) {
  const Scene scene = read_scene(options.scene.named(options.json), options.scene.overrides);
  const std::unique_ptr<Device> device = open_device(options.device.request(), notice);
  const CheckReport report = check_scene(scene, *device);
  if (options.json.wanted())
    options.json.write(check_json(report).dump(2));
  else
    std::fputs(check_text(report).c_str(), stdout);
  return ExitCode::good;
}

} // namespace

void add_check(CLI::App& program, Action& action) {
  CLI::App* command = program.add_subcommand(
      "check", "validate a scene; its geometry and memory, how stiff it is, an estimate of the time");
  const auto options = std::make_shared<Options>();
  add_scene(*command, options->scene);
  add_backend(*command, options->device);
  add_threads(*command, options->device);
  add_precision(*command, options->device);
  add_json(*command, options->json, "print JSON, or write it to FILE");
  command->footer(R"(Examples:
  pliant check drop.toml
  pliant check examples/beam.toml --set simulation.spacing=0.01 --json)");
  command->callback([&action, options] { action = [options] { return check(*options); }; });
}

} // namespace pliant::cli
