// pliant curve: stress against stretch of a scene's materials.
#include "engine/cli/commands.h"
#include "engine/report/stress_curve.h"
#include "engine/scene/scene_parse.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace pliant::cli {

namespace {

struct Options {
  SceneChoice scene;
  JsonChoice json;
  StressCurveOptions curve;
  std::string out;
};

ExitCode curve(Options& options) {
  const Scene scene = read_scene(options.scene.named(options.json), options.scene.overrides);
  const StressCurveReport report = stress_curves(scene, options.curve);
  if (!options.out.empty()) {
    std::error_code error;
    std::filesystem::create_directories(options.out, error);
    if (error) throw Error(ExitCode::input_output, "--out " + options.out + ": " + error.message());
    for (const std::filesystem::path& file : write_stress_curves(report, options.out))
      notice("wrote " + file.string());
  }
  if (options.json.wanted()) options.json.write(stress_curve_json(report).dump(2));
  if (options.json.target() != "-") std::fputs(stress_curve_text(report).c_str(), stdout);
  return ExitCode::good;
}

} // namespace

void add_curve(CLI::App& program, Action& action) {
  CLI::App* command = program.add_subcommand(
      "curve", "stress against stretch of a scene's materials: lattice, continuum, closed formula");
  const auto options = std::make_shared<Options>();
  add_scene(*command, options->scene);
  command
      ->add_option("--material", options->curve.materials, "these materials of the scene; all unless given")
      ->type_name("NAME,...")
      ->delimiter(',');
  command
      ->add_option(
          "--out", options->out,
          "folder for curve.csv, curve.json and NAME.svg, NAME.png of each material; made if need be")
      ->type_name("FOLDER");
  command->add_option("--from", options->curve.from, "smallest stretch")
      ->capture_default_str()
      ->type_name("S")
      ->check(CLI::Range(0.05, 10.0).description(""));
  command->add_option("--to", options->curve.to, "largest stretch")
      ->capture_default_str()
      ->type_name("S")
      ->check(CLI::Range(0.05, 10.0).description(""));
  add_json(*command, options->json, "print curve.json too, or write it to FILE");
  command->footer(
      R"(Tests: uniaxial, equibiaxial and pure shear (a wide strip), along x; sides that are not held are free of stress.
"lattice" is a particle inside a body with the scene's horizon and weights, "continuum" the average over the sphere
that it stands for, "closed" the classical law of the same constants.
Examples:
  pliant curve examples/stress-strain.toml --out out/curves
  pliant curve my-scene.toml --material rubber --from 0.8 --to 1.2)");
  command->callback([&action, options] { action = [options] { return curve(*options); }; });
}

} // namespace pliant::cli
