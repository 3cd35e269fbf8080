#include "engine/cli/commands.h"
#include <CLI/CLI.hpp>
namespace pliant::cli {
void add_verify(CLI::App& program, Action&) {
  program.add_subcommand("verify", "")->footer("Example:");
}
} // namespace pliant::cli
