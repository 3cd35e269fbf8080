// pliant bench: kernels and scenes on each backend, measured.
#include "engine/cli/commands.h"
#include "engine/report/bench.h"

#include <CLI/CLI.hpp>
#include <iostream>

namespace pliant::cli {

namespace {

struct Options {
  BenchOptions bench;
  JsonChoice json;
};

} // namespace

void add_bench(CLI::App& program, Action& action) {
  CLI::App* command = program.add_subcommand(
      "bench", "measure every kernel and the reference scenes on each backend: ms, ns a bond, GB/s, memory");
  const auto options = std::make_shared<Options>();
  command->footer(R"(Examples:
  pliant bench --quick
  pliant bench --backend openmp --json bench.json
  pliant bench --baseline bench.json)");
  command->callback([&action, options] {
    action = [options] { return static_cast<ExitCode>(run_bench(options->bench, std::cout)); };
  });
}

} // namespace pliant::cli
