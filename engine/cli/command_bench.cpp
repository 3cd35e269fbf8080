// pliant bench: kernels and scenes on each backend, measured.
#include "engine/cli/commands.h"
#include "engine/report/bench.h"

#include <CLI/CLI.hpp>
#include <iostream>
#include <sstream>

namespace pliant::cli {

namespace {

struct Options {
  BenchOptions bench;
  JsonChoice json;
};

ExitCode bench(Options& options) {
  options.bench.json = options.json.wanted();
  if (!options.json.wanted()) return static_cast<ExitCode>(run_bench(options.bench, std::cout));
  std::ostringstream text;
  const auto code = static_cast<ExitCode>(run_bench(options.bench, text));
  std::string json = text.str();
  if (!json.empty() && json.back() == '\n') json.pop_back();
  options.json.write(json);
  return code;
}

} // namespace

void add_bench(CLI::App& program, Action& action) {
  CLI::App* command = program.add_subcommand(
      "bench", "measure every kernel and the reference scenes on each backend: ms, ns a bond, GB/s, memory");
  const auto options = std::make_shared<Options>();
  command
      ->add_option("--backend", options->bench.backends,
                   "openmp, gl or gl:N; may be repeated; all unless given")
      ->type_name("NAME")
      ->expected(1)
      ->take_all();
  command->add_option("--sizes", options->bench.sizes, "numbers of particles of the box, e.g. 25000,1000000")
      ->type_name("N,N,...")
      ->delimiter(',')
      ->check(CLI::Range(std::size_t{1000}, std::size_t{100'000'000}).description(""));
  command->add_flag("--quick", options->bench.quick, "small sizes and few repetitions: does it work at all");
  command->add_option("--baseline", options->bench.baseline, "compare with the JSON of an earlier bench")
      ->type_name("FILE")
      ->check(CLI::ExistingFile.description(""));
  add_json(*command, options->json, "print JSON, or write it to FILE");
  command->footer(R"(Examples:
  pliant bench --quick
  pliant bench --backend openmp --json bench.json
  pliant bench --sizes 25000,1000000 --baseline bench.json)");
  command->callback([&action, options] { action = [options] { return bench(*options); }; });
}

} // namespace pliant::cli
