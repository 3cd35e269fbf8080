// One file a command: each adds its words to the parser and, if the user calls it, leaves what is to be done.
#pragma once

#include "engine/core/error.h"
#include "engine/device/device.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
} // namespace CLI

namespace pliant::cli {

/// What the command line asked for; runs after parsing, so that a failure of it is none of the parser's.
using Action = std::function<ExitCode()>;

void add_run(CLI::App& program, Action& action);
void add_plan(CLI::App& program, Action& action);
void add_check(CLI::App& program, Action& action);
void add_curve(CLI::App& program, Action& action);
void add_converge(CLI::App& program, Action& action);
void add_verify(CLI::App& program, Action& action);
void add_stability(CLI::App& program, Action& action);
void add_bench(CLI::App& program, Action& action);
void add_doctor(CLI::App& program, Action& action);
void add_scenes(CLI::App& program, Action& action);
void add_new(CLI::App& program, Action& action);
void add_schema(CLI::App& program, Action& action);

/// `--json [FILE]`: to standard output, or to the file named.
struct JsonChoice {
  CLI::Option* option = nullptr;
  std::string file;
  bool wanted() const;
  /// "" where it is not wanted, "-" for standard output, else a file.
  std::string target() const;
  /// Throws Error(input_output).
  void write(const std::string& text) const;
};
void add_json(CLI::App& command, JsonChoice& json, const std::string& meaning);

/// SCENE and `--set key=value`.
struct SceneChoice {
  std::string file;
  std::vector<std::string> overrides;
  /// The scene named. In `plan --json SCENE` the parser gives the scene to --json: it is taken back here.
  /// Throws Error(usage) where none is named.
  std::string named(JsonChoice& json) const;
};
void add_scene(CLI::App& command, SceneChoice& scene);

/// `--backend`, and where the command has them `--threads` and `--precision`.
struct DeviceChoice {
  std::string backend = "auto";
  unsigned threads = 0;
  std::string precision = "float";
  DeviceRequest request() const;
};
void add_backend(CLI::App& command, DeviceChoice& device);
void add_threads(CLI::App& command, DeviceChoice& device);
void add_precision(CLI::App& command, DeviceChoice& device);

/// One line on standard error, under the program's name.
void notice(const std::string& line);

} // namespace pliant::cli
