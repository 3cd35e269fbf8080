// pliant bench: kernels and scenes on each backend, measured.
#include "engine/cli/commands.h"
#include "engine/io/folder.h"
#include "engine/report/bench.h"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <unistd.h>

namespace pliant::cli {

namespace {

struct Options {
  BenchOptions bench;
  JsonChoice json;
};

// Tables go to standard output; with --json they go to standard error, and the JSON to its place.
ExitCode bench(Options& options) {
  if (!options.json.wanted()) return static_cast<ExitCode>(run_bench(options.bench, std::cout));
  const std::filesystem::path scratch =
      std::filesystem::temp_directory_path() / ("pliant-bench-" + std::to_string(getpid()) + ".json");
  options.bench.json_file = scratch.string();
  const auto code = static_cast<ExitCode>(run_bench(options.bench, std::cerr));
  std::string json = read_text_file(scratch);
  std::filesystem::remove(scratch);
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
  command
      ->add_option("--sizes", options->bench.sizes,
                   "beam (3,000 particles), bunny (25,000), box (1,000,000); all unless given")
      ->type_name("NAME,...")
      ->delimiter(',')
      ->check(CLI::IsMember({"beam", "bunny", "box"}).description(""));
  command->add_flag("--quick", options->bench.quick, "without the box, few repetitions: does it work at all");
  command->add_option("--baseline", options->bench.baseline, "compare with the JSON of an earlier bench")
      ->type_name("FILE")
      ->check(CLI::ExistingFile.description(""));
  add_json(*command, options->json, "print JSON, or write it to FILE");
  command->footer(R"(Examples:
  pliant bench --quick
  pliant bench --backend openmp --json bench.json
  pliant bench --sizes bunny,box --baseline bench.json)");
  command->callback([&action, options] { action = [options] { return bench(*options); }; });
}

} // namespace pliant::cli
