// Options that several commands share.
#include "engine/cli/commands.h"
#include "engine/io/folder.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>

namespace pliant::cli {

bool JsonChoice::wanted() const {
  return option && option->count() > 0;
}

std::string JsonChoice::target() const {
  return !wanted() ? "" : file.empty() ? "-" : file;
}

void JsonChoice::write(const std::string& text) const {
  if (target() == "-")
    std::fputs((text + "\n").c_str(), stdout);
  else
    write_text_file(file, text + "\n");
}

void add_json(CLI::App& command, JsonChoice& json, const std::string& meaning) {
  json.option = command.add_option("--json", json.file, meaning)->expected(0, 1)->type_name("[FILE]");
}

std::string SceneChoice::named(JsonChoice& json) const {
  if (!file.empty()) return file;
  if (std::filesystem::path(json.file).extension() != ".toml")
    throw Error(ExitCode::usage, "no scene is named; `pliant scenes` lists some, `pliant new` writes one");
  std::string scene;
  std::swap(scene, json.file);
  return scene;
}

void add_scene(CLI::App& command, SceneChoice& scene) {
  command.add_option("SCENE", scene.file, "a scene file (TOML)")->type_name("");
  command
      .add_option("--set", scene.overrides,
                  "change one value of the scene, e.g. solver.tolerance=1e-4; may be repeated")
      ->type_name("KEY=VALUE")
      ->expected(1)
      ->take_all();
}

DeviceRequest DeviceChoice::request() const {
  DeviceRequest request;
  request.backend = backend;
  request.threads = threads;
  request.precision = precision == "double" ? Precision::double_precision : Precision::single_precision;
  return request;
}

void add_backend(CLI::App& command, DeviceChoice& device) {
  command.add_option("--backend", device.backend, "auto, openmp, gl or gl:N (see `pliant doctor`)")
      ->capture_default_str()
      ->type_name("NAME");
}

void add_threads(CLI::App& command, DeviceChoice& device) {
  command.add_option("--threads", device.threads, "of the openmp backend; all processors unless given")
      ->type_name("N")
      ->check(CLI::Range(1u, 4096u).description(""));
}

void add_precision(CLI::App& command, DeviceChoice& device) {
  command.add_option("--precision", device.precision, "float, or double (openmp only)")
      ->capture_default_str()
      ->type_name("NAME")
      ->check(CLI::IsMember({"float", "double"}).description(""));
}

void notice(const std::string& line) {
  std::fprintf(stderr, "pliant: %s\n", line.c_str());
}

} // namespace pliant::cli
