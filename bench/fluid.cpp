// How long fluids take: cells and lists of neighbours a particle at a million particles, five iterations of
// the density constraint at 50,000, and each part of a step of honey, which is viscous and spreads, at
// 72,000. Lattices shaken by a quarter of a spacing, in single precision on the CPU; medians and the least of
// some steps after two to warm up. A third argument 0 prints the time of the processor instead, for busy
// machines: it means something on one thread only. A fourth names one of the three.
//
//   build/bench/fluid [THREADS [STEPS [WALL [lists|density|honey]]]]
#include "engine/solver/fluid.h"
#include "engine/solver/simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <map>
#include <random>
#include <vector>

using namespace pliant;

namespace {

constexpr double spacing = 0.01;
constexpr int large = 100, small = 37, medium = 42; // particles a side

double seconds(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Milliseconds of each component in each step.
std::map<std::string, std::vector<double>> measure(int side, const Material& fluid, double time_step,
                                                   unsigned threads, int steps, bool wall) {
  std::vector<Vector3> points;
  for (int z = 0; z < side; ++z)
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) points.push_back(Vector3(x, y, z) * spacing);
  Scene scene;
  scene.simulation.spacing = spacing;
  scene.simulation.gravity = Vector3::Zero();
  scene.simulation.time_step = time_step;
  scene.output.fps = 1 / time_step;
  scene.materials = {fluid};
  Model model = assemble_points(points, spacing, 1.87, fluid, spacing * spacing * spacing);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> shake(-0.25 * spacing, 0.25 * spacing);
  for (Vector3& p : model.position) p += Vector3(shake(random), shake(random), shake(random));
  const auto device = open_device({"openmp", Precision::single_precision, threads, false});
  PlanRequest request;
  request.statistics = false;
  Simulation simulation(*device, scene, model, request);
  simulation.measure(true);
  std::map<std::string, std::vector<double>> spent;
  const Snapshot start = simulation.snapshot();
  for (int k = 0; k < steps + 2; ++k) {
    simulation.restore(start);
    device->take_timings();
    const double before = seconds(CLOCK_PROCESS_CPUTIME_ID);
    simulation.step();
    const double processor = 1e3 * (seconds(CLOCK_PROCESS_CPUTIME_ID) - before);
    double all = 0;
    const std::vector<Timing> timings = device->take_timings();
    for (const Timing& timing : timings) all += timing.milliseconds;
    if (k < 2) continue;
    for (const Timing& timing : timings)
      spent[timing.component].push_back(timing.milliseconds * (wall || all == 0 ? 1 : processor / all));
  }
  for (auto& [component, values] : spent) std::sort(values.begin(), values.end());
  std::printf("%d particles, %u threads, hash %s\n", side * side * side, device->info().threads,
              simulation.hash().c_str());
  return spent;
}

double middle(const std::vector<double>& sorted) {
  return sorted[sorted.size() / 2];
}

} // namespace

int main(int count, char** arguments) {
  if (count > 1 && arguments[1][0] == '-') {
    fmt::print("fluid [THREADS [STEPS [WALL [PART]]]]: time of neighbour lists, density and forces of "
               "fluids; WALL 0 "
               "counts the processor's; PART is one of lists, density, honey\n");
    return std::string(arguments[1]) == "--help" ? 0 : 2;
  }
  const auto number = [&](int at, int otherwise) {
    return count > at ? std::atoi(arguments[at]) : otherwise;
  };
  const auto threads = static_cast<unsigned>(number(1, 0));
  const int steps = number(2, 5);
  const bool wall = number(3, 1) != 0;
  const std::string part = count > 4 ? arguments[4] : "";
  const auto wanted = [&](const char* name) { return part.empty() || part == name; };
  Material water;
  water.name = "water";
  water.model = "fluid";
  const auto nanoseconds = [](int side) { return 1e6 / std::pow(side, 3); }; // a particle, of a millisecond
  if (wanted("lists")) {
    const auto lists = measure(large, water, 1e-5, threads, steps, wall).at("neighbours");
    std::printf("  cells and lists: median %.1f, least %.1f ns a particle\n",
                nanoseconds(large) * middle(lists), nanoseconds(large) * lists.front());
  }
  if (wanted("density")) {
    const auto density = measure(small, water, 1e-5, threads, steps, wall).at("density");
    std::printf("  density, 5 iterations and the step's start and end: median %.2f, least %.2f ms\n",
                middle(density), density.front());
  }
  if (wanted("honey")) {
    Material honey = water;
    honey.name = "honey";
    honey.viscosity = 50;
    honey.redistribution = 1;
    double all = 0;
    for (const auto& [component, values] : measure(medium, honey, 0.004, threads, steps, wall)) {
      std::printf("  honey, %s: median %.1f, least %.1f ns a particle\n", component.c_str(),
                  nanoseconds(medium) * middle(values), nanoseconds(medium) * values.front());
      all += nanoseconds(medium) * middle(values);
    }
    std::printf("  honey, all: %.1f ns a particle\n", all);
  }
}
