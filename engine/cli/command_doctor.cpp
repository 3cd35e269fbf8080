// pliant doctor: what this machine offers, and what to install for the rest.
#include "engine/cli/commands.h"
#include "engine/report/doctor.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace pliant::cli {

void add_doctor(CLI::App& program, Action& action) {
  CLI::App* command = program.add_subcommand(
      "doctor",
      "backends, GL devices and limits, libraries, meshes; for each thing missing the package to install");
  const auto json = std::make_shared<JsonChoice>();
  add_json(*command, *json, "print JSON, or write it to FILE");
  command->footer(R"(Examples:
  pliant doctor
  pliant doctor --json doctor.json)");
  command->callback([&action, json] {
    action = [json] {
      const Diagnosis diagnosis = diagnose();
      if (json->wanted())
        json->write(diagnosis_json(diagnosis).dump(2));
      else
        std::fputs(diagnosis_text(diagnosis).c_str(), stdout);
      return ExitCode::good;
    };
  });
}

} // namespace pliant::cli
