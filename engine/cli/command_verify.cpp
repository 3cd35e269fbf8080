// pliant verify: double against float against GL.
#include "engine/cli/commands.h"
#include "engine/report/verify.h"
#include "engine/scene/scene_parse.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace pliant::cli {

namespace {

struct Options {
  SceneChoice scene;
  JsonChoice json;
  VerifyOptions verify;
  bool quick = false, kernels = false;
};

ExitCode verify(Options& options, bool steps_given) {
  VerifyOptions& verify = options.verify;
  verify.kernels = options.kernels || !options.quick;
  verify.say = notice;
  const Scene scene = read_scene(options.scene.named(options.json), options.scene.overrides);
  if (options.quick && !steps_given) verify.steps = 2 * stretch_length(verify, scene);
  const VerifyReport report = verify_scene(scene, verify);
  if (options.json.wanted())
    options.json.write(verify_json(report).dump(2));
  else
    std::fputs(verify_text(report).c_str(), stdout);
  return report.good() ? ExitCode::good : ExitCode::internal;
}

} // namespace

void add_verify(CLI::App& program, Action& action) {
  CLI::App* command = program.add_subcommand(
      "verify",
      "compare double with float and with GL, field by field and kernel by kernel; are runs repeatable");
  const auto options = std::make_shared<Options>();
  add_scene(*command, options->scene);
  CLI::Option* steps =
      command
          ->add_option("--steps", options->verify.steps, "of the run in double that others are compared with")
          ->capture_default_str()
          ->type_name("N")
          ->check(CLI::Range(1u, 1'000'000u).description(""));
  command
      ->add_option("--every", options->verify.every,
                   "steps from one restart to the next; 10, of fluids 5 unless given")
      ->type_name("N")
      ->check(CLI::Range(1u, 1'000'000u).description(""));
  command
      ->add_option(
          "--iterations", options->verify.iterations,
          "of each step, whatever its residual; 200 or more of viscoelastic matter; a scene that names "
          "newton, lbfgs or direct has its steps solved instead")
      ->capture_default_str()
      ->type_name("N")
      ->check(CLI::Range(1u, 1'000'000u).description(""));
  command->add_flag("--quick", options->quick, "two stretches instead of ten, and no replay of kernels");
  command->add_flag("--kernels", options->kernels, "replay kernels of one GL step on the CPU even so");
  add_json(*command, options->json, "print JSON, or write it to FILE");
  command->footer(R"(Ends with 0 where all differences are within their limits, else with 1.
Examples:
  pliant verify drop.toml --quick
  pliant verify examples/armadillo.toml --json verify.json)");
  command->callback([&action, options, steps] {
    action = [options, steps] { return verify(*options, steps->count() > 0); };
  });
}

} // namespace pliant::cli
