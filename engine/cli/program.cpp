// The commands under one roof: help, version, and how failures end.
#include "engine/cli/program.h"

#include "engine/cli/commands.h"
#include "engine/scene/scene_parse_findings.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <new>

namespace pliant {

namespace {

constexpr const char* examples = R"(Examples:
  pliant new drop                              write a scene to start from, drop.toml
  pliant check drop.toml                       is it sound, how large, how long will it take
  pliant run drop.toml --out out/drop          simulate, draw, store
  pliant doctor                                what this machine offers, and what is missing

`pliant COMMAND --help` explains a command. Exit codes: 0 good, 1 internal fault, 2 command line or scene,
3 no such device, 4 diverged, 5 input or output, 6 does not fit the device, 130 or 143 interrupted.)";

int failed(ExitCode code, const std::string& message) {
  std::fflush(stdout);
  std::fprintf(stderr, "pliant: %s\n", message.c_str());
  return static_cast<int>(code);
}

std::vector<std::string> command_names(const CLI::App& program) {
  std::vector<std::string> names;
  for (const CLI::App* command : program.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(command->get_name());
  return names;
}

/// The parser's reason, with where to read on; a word that is no command gets the nearest one.
std::string usage_message(const CLI::App& program, const CLI::ParseError& error, int argc, char** argv) {
  const std::vector<CLI::App*> called = program.get_subcommands();
  if (called.empty()) {
    if (argc < 2) return "no command is given; `pliant --help` lists them";
    const std::string first = argv[1];
    if (first.rfind('-', 0) != 0)
      return "no command " + in_quotes(first) + suggestion(first, command_names(program));
    return "a command is wanted first, not " + in_quotes(first) + "; see `pliant --help`";
  }
  return std::string(error.what()) + "; see `pliant " + called.front()->get_name() + " --help`";
}

int parse_and_run(int argc, char** argv) {
  CLI::App program{
      "Pliant simulates elastic and plastic matter as particles, on processors and GPUs, without a "
      "display."};
  program.name("pliant");
  program.set_version_flag("--version", "pliant " PLIANT_VERSION, "print the version and end");
  program.set_help_flag("-h,--help", "print this text and end");
  program.require_subcommand(1);
  program.footer(examples);
  program.get_formatter()->column_width(26);
  program.get_formatter()->label("SUBCOMMAND", "COMMAND");
  program.get_formatter()->label("OPTIONS", "options");
  program.get_formatter()->label("Positionals", "Arguments");
  cli::Action action;
  cli::add_run(program, action);
  cli::add_plan(program, action);
  cli::add_check(program, action);
  cli::add_curve(program, action);
  cli::add_converge(program, action);
  cli::add_verify(program, action);
  cli::add_stability(program, action);
  cli::add_bench(program, action);
  cli::add_doctor(program, action);
  cli::add_scenes(program, action);
  cli::add_new(program, action);
  cli::add_schema(program, action);
  for (CLI::App* command : program.get_subcommands([](const CLI::App*) { return true; }))
    command->group("Commands");
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {
      program.exit(error); // prints the help or the version
    } else {
      return failed(ExitCode::usage, usage_message(program, error, argc, argv));
    }
  }
  const ExitCode code = action ? action() : ExitCode::good;
  if (std::fflush(stdout) != 0 || std::ferror(stdout))
    return failed(ExitCode::input_output, "standard output cannot be written to: is the disk full?");
  return static_cast<int>(code);
}

} // namespace

int run_program(int argc, char** argv) {
  try {
    return parse_and_run(argc, argv);
  } catch (const Error& error) {
    return failed(error.code(), error.what());
  } catch (const std::bad_alloc&) {
    return failed(ExitCode::too_large,
                  "this machine has not the memory that it takes; a larger spacing needs less");
  } catch (const std::exception& error) {
    return failed(ExitCode::internal, std::string("internal fault: ") + error.what());
  } catch (...) {
    return failed(ExitCode::internal, "internal fault of an unknown kind");
  }
}

} // namespace pliant
