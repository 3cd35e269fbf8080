// How long whole steps take, beside Table 1 of He, Wang and Wu (2017): honey, two bunnies and dripping honey
// at the table's numbers of particles and the scenes' time steps, with five iterations of each component, in
// single precision on the CPU. Medians of the last steps; under the wall's time stands the processor's, which
// tells on busy machines how much of it was waiting. The honey that drips bears a pull of 100 Pa: without,
// what hangs is drawn out and 2 % too thin in the mean, however many sweeps are made.
//
//   build/bench/steps FOLDER [THREADS [STEPS [SCENE]]]      FOLDER: that of the scenes, examples
#include "engine/core/error.h"
#include "engine/scene/scene_parse.h"
#include "engine/solver/simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <ctime>
#include <map>

using namespace pliant;

namespace {

struct Column {
  const char* name;
  std::vector<const char*> components; ///< ours that go into it
};
const std::array columns{
    Column{"neighbours", {"neighbours"}},
    Column{"density", {"density", "boundaries"}},
    Column{"redistribution", {"redistribution"}},
    Column{"plastic", {"plasticity"}},
    Column{"elastic", {"elasticity", "solver", "motion", "contacts", "momentum", "preconditioner", "direct"}},
    Column{"viscosity", {"viscosity"}}};

struct Case {
  std::string name;
  std::vector<std::string> overrides;
  int before;                                ///< steps that are not counted
  std::array<double, columns.size()> theirs; ///< ms, on four cores of 2011; 0: the table has none
  double sum;
  double target; ///< ms, on two cores
};

const std::vector<Case> cases{
    {"honey", {}, 160, {34.0, 26.9, 32.4, 4.9, 24.0, 0}, 125.4, 45},
    {"two-bunnies", {"solver.method=chebyshev"}, 60, {0, 22.1, 0, 4.1, 23.7, 0}, 53.6, 25},
    {"dripping",
     {"simulation.spacing=0.000787", "materials.honey.tensile_strength=100"},
     4,
     {221.9, 211.0, 253.1, 38.2, 233.0, 0},
     982.2,
     350}};

double seconds(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 0 : values[values.size() / 2];
}

/// What has been poured after some seconds, so that a bench need not pour it, and room for what is born while
/// it looks.
void pour(Scene& scene) {
  scene.emitters.front().particles = 12000;
  Body& heap = scene.bodies.emplace_back();
  heap.name = "heap";
  heap.material = "honey";
  heap.shape.kind = Shape::Kind::cylinder;
  heap.shape.radius = 0.0874, heap.shape.height = 0.0425;
  heap.shape.at = {0, heap.shape.height / 2, 0};
}

void measure(const Case& one, const std::string& folder, unsigned threads, int steps) {
  Scene scene = read_scene(folder + "/" + one.name + ".toml", one.overrides);
  if (one.name == "honey") pour(scene);
  constexpr unsigned iterations = 5;
  scene.solver.iterations = iterations;
  scene.solver.fixed_iterations = true;
  scene.fluid.density_iterations = scene.fluid.redistribution_iterations = scene.fluid.viscosity_iterations =
      iterations;
  const Model model = assemble(scene);
  const auto device = open_device({"openmp", Precision::single_precision, threads, false});
  Simulation simulation(*device, scene, model);
  simulation.measure(true);
  std::map<std::string, std::vector<double>> spent;
  std::vector<double> wall, processor, error, worst;
  std::size_t present = model.count();
  double taken = 0;
  for (int k = 0; k < one.before + steps; ++k) {
    device->take_timings();
    const double began = seconds(CLOCK_MONOTONIC), worked = seconds(CLOCK_PROCESS_CPUTIME_ID);
    simulation.step();
    device->finish();
    const double ended = seconds(CLOCK_MONOTONIC), done = seconds(CLOCK_PROCESS_CPUTIME_ID);
    const std::vector<StepStatistics> rows = simulation.take_statistics();
    if (simulation.plan().fluid_sources) present = rows.back().present;
    if (k < one.before) continue;
    wall.push_back(1e3 * (ended - began));
    processor.push_back(1e3 * (done - worked));
    for (const Timing& timing : device->take_timings())
      spent[timing.component].push_back(timing.milliseconds);
    for (const StepStatistics& row : rows) {
      error.push_back(row.density_error);
      taken += row.iterations;
    }
  }
  fmt::print("{}: {} particles, {} threads, medians of {} steps\n  {:16}", one.name, present,
             device->info().threads, steps, "ms");
  for (const Column& column : columns) fmt::print("{:>16}", column.name);
  fmt::print("{:>12}\n  {:16}", "step", "here");
  for (const Column& column : columns) {
    double sum = 0;
    for (const char* component : column.components)
      if (const auto found = spent.find(component); found != spent.end()) sum += median(found->second);
    fmt::print("{:>16.1f}", sum);
  }
  fmt::print("{:>12.1f}\n  {:16}", median(wall), "Table 1");
  for (const double ms : one.theirs) fmt::print("{:>16}", ms > 0 ? fmt::format("{:.1f}", ms) : "-");
  fmt::print("{:>12.1f}\n  processor {:.1f} ms a step, all threads together; target {:.0f} ms on two cores\n",
             one.sum, median(processor), one.target);
  fmt::print("  by component:");
  for (const auto& [component, values] : spent) fmt::print(" {} {:.1f}", component, median(values));
  fmt::print(" ms; {:.0f} iterations in the mean\n", taken / steps);
  if (simulation.plan().fluid) fmt::print("  mean density error inside {:.2f} %\n", 100 * median(error));
  std::fflush(stdout);
}

} // namespace

int main(int count, char** arguments) {
  if (count > 1 && arguments[1][0] == '-') {
    fmt::print(
        "steps [FOLDER [THREADS [STEPS [SCENE]]]]: milliseconds a step of honey, two-bunnies and dripping in "
        "FOLDER, examples unless given; two threads, medians of nine steps\n");
    return std::string(arguments[1]) == "--help" ? 0 : 2;
  }
  const auto number = [&](int at, int otherwise) {
    return count > at ? std::atoi(arguments[at]) : otherwise;
  };
  const std::string folder = count > 1 ? arguments[1] : "examples", only = count > 4 ? arguments[4] : "";
  try {
    for (const Case& one : cases)
      if (only.empty() || only == one.name)
        measure(one, folder, static_cast<unsigned>(number(2, 2)), std::max(number(3, 9), 1));
  } catch (const Error& error) {
    fmt::print(stderr, "steps: {}\n", error.what());
    return static_cast<int>(error.code());
  }
  return 0;
}
