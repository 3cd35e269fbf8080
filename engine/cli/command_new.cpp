// pliant new: a scene to start from.
#include "engine/cli/commands.h"
#include "engine/io/folder.h"
#include "engine/scene/scene_new.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <fmt/format.h>

namespace pliant::cli {

namespace {

struct Options {
  std::string kind, file;
};

ExitCode write_scene(const Options& options) {
  if (options.kind.empty()) {
    for (const auto& [kind, about] : new_scene_kinds())
      std::fputs(fmt::format("{:<8}{}\n", kind, about).c_str(), stdout);
    return ExitCode::good;
  }
  const std::string text = new_scene_text(options.kind);
  if (options.file == "-") {
    std::fputs(text.c_str(), stdout);
    return ExitCode::good;
  }
  const std::filesystem::path file = options.file.empty() ? options.kind + ".toml" : options.file;
  std::error_code ignored;
  if (std::filesystem::exists(std::filesystem::symlink_status(file, ignored)))
    throw Error(ExitCode::input_output,
                fmt::format("{} is there already and is left alone: name another file", file.string()));
  write_text_file(file, text);
  std::fputs(fmt::format("wrote {}; next: pliant check {}\n", file.string(), file.string()).c_str(), stdout);
  return ExitCode::good;
}

} // namespace

void add_new(CLI::App& program, Action& action) {
  CLI::App* command = program.add_subcommand("new", "write a commented scene to start from");
  const auto options = std::make_shared<Options>();
  command->add_option("KIND", options->kind, "drop, beam, ...; without it the kinds are listed")
      ->type_name("");
  command->add_option("FILE", options->file, "<kind>.toml unless given; - for standard output")
      ->type_name("");
  command->footer(R"(Examples:
  pliant new
  pliant new drop
  pliant new beam my-beam.toml)");
  command->callback([&action, options] { action = [options] { return write_scene(*options); }; });
}

} // namespace pliant::cli
