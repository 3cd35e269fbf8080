// pliant plan: the components, kernels, buffers and bytes of a scene.
#include "engine/cli/commands.h"
#include "engine/plan/plan_report.h"
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

ExitCode plan(Options& options) {
  const Scene scene = read_scene(options.scene.named(options.json), options.scene.overrides);
  const Model model = assemble(scene);
  PlanRequest request;
  request.frames = true;
  request.divergence = true;
  request.fields = scene.output.fields;
  const Plan plan = make_plan(scene, model, slice_bonds(model), request);
  const DeviceRequest device = options.device.request();
  if (options.json.wanted())
    options.json.write(plan_json(plan, device.precision).dump(2));
  else
    std::fputs(plan_text(plan, device.precision).c_str(), stdout);
  return ExitCode::good;
}

} // namespace

void add_plan(CLI::App& program, Action& action) {
  CLI::App* command = program.add_subcommand(
      "plan", "the components, kernels, buffers and bytes that a scene will use, and those it leaves out");
  const auto options = std::make_shared<Options>();
  add_scene(*command, options->scene);
  add_backend(*command, options->device);
  add_precision(*command, options->device);
  add_json(*command, options->json, "print JSON, or write it to FILE");
  command->footer(R"(Example:
  pliant plan examples/main-job.toml)");
  command->callback([&action, options] { action = [options] { return plan(*options); }; });
}

} // namespace pliant::cli
