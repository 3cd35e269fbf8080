#include "engine/cli/commands.h"
#include <CLI/CLI.hpp>
namespace pliant::cli {
void add_check(CLI::App& program, Action&) {
  program.add_subcommand("check", "")->footer("Example:");
}
} // namespace pliant::cli
