// pliant schema: every key of a scene file.
#include "engine/cli/commands.h"
#include "engine/scene/scene_schema.h"

#include <CLI/CLI.hpp>
#include <cstdio>

namespace pliant::cli {

void add_schema(CLI::App& program, Action& action) {
  CLI::App* command =
      program.add_subcommand("schema", "every key of a scene file: unit, range, default, meaning");
  const auto json = std::make_shared<JsonChoice>();
  add_json(*command, *json, "a JSON Schema (draft 2020-12) instead, printed or written to FILE");
  command->footer(R"(Examples:
  pliant schema | less
  pliant schema --json scene.schema.json      for editors that complete and check TOML)");
  command->callback([&action, json] {
    action = [json] {
      if (json->wanted())
        json->write(schema_json());
      else
        std::fputs(schema_text().c_str(), stdout);
      return ExitCode::good;
    };
  });
}

} // namespace pliant::cli
