// Five scenes of the particle counts and time steps of Table 1 of Xu et al. (2018): milliseconds a frame (one
// frame is one step), iterations, and how far from its converged step each of some sampled steps ended, as
// Eq. 25 counts: (Phi - Phi*) / (Phi_0 - Phi*), in double, Phi* of a second solver that goes on until no
// descent is left, from where the first ended; not of steps that begin at rest or in free flight, as close to
// their end as the precision can tell. Writes table1.csv.
//
//   build/bench/table1 [FOLDER [SCENES [NAME ...]]]      from the repository's root; two threads
#include "engine/core/error.h"
#include "engine/report/converge_problem.h"
#include "engine/scene/scene_parse.h"
#include "engine/solver/simulation.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>

using namespace pliant;

namespace {

constexpr unsigned threads = 2, samples = 12;

struct Row {
  const char* name;
  double paper_iterations, paper_ms; ///< a frame, their Table 1
};
constexpr Row rows[] = {{"flower", 20.3, 104},
                        {"armadillo", 9.6, 323},
                        {"cloth", 6.2, 146},
                        {"cylinder", 10.4, 57},
                        {"bunny", 16.8, 1300}};

/// The same step solved to the end, in double.
class Judge {
public:
  Judge(const Scene& scene, const Model& model) : model_(model), scene_(reference_scene(scene, model)) {
    scene_.solver.fixed_iterations = true; // it ends where no descent is left
    scene_.solver.iterations = 400;
    device_ = open_device(double_precision(threads));
    for (auto* simulation : {&judge_, &solver_})
      *simulation = std::make_unique<Simulation>(*device_, scene_, model);
  }
  /// Eq. 25 of where a step from `start` ended.
  double error(const Snapshot& start, std::vector<Vector3> end) {
    judge_->restore(start);
    judge_->begin_solving();
    const std::vector<Vector3> guess = judge_->iterate_positions();
    for (const Held& held : model_.held) end[held.particle] = guess[held.particle]; // a float rounds them
    const double first = judge_->potential(guess), found = judge_->potential(end);
    solver_->restore(start);
    solver_->begin_solving();
    solver_->start_from(end);
    while (!solver_->iterate()) {
    }
    const double least = judge_->potential(solver_->iterate_positions());
    return (found - least) / (first - least);
  }

private:
  const Model& model_;
  Scene scene_;
  std::unique_ptr<Device> device_;
  std::unique_ptr<Simulation> judge_, solver_;
};

struct Result {
  std::size_t particles = 0;
  std::string method;
  double step = 0, ms = 0, iterations = 0, error = 0, estimate = 0;
  unsigned steps = 0, caps = 0, rises = 0, judged = 0;
};

Result measure(const std::filesystem::path& file) {
  const Scene scene = read_scene(file, {});
  const Model model = assemble(scene);
  const std::unique_ptr<Device> device = open_device({"openmp", Precision::single_precision, threads});
  Simulation simulation(*device, scene, model);
  Judge judge(scene, model);
  Result result;
  const Method& method = simulation.plan().method;
  result.particles = model.count();
  result.method = method.name + (method.preconditioner.empty() ? "" : "+" + method.preconditioner);
  result.step = simulation.time_step();
  result.steps = static_cast<unsigned>(std::lround(scene.simulation.end / result.step));
  const unsigned every = std::max(1u, result.steps / samples);
  for (unsigned k = 0; k < result.steps; ++k) {
    const bool sampled = k % every == every / 2;
    const Snapshot start = sampled ? simulation.snapshot() : Snapshot{};
    const auto began = std::chrono::steady_clock::now();
    simulation.step();
    device->finish();
    result.ms += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - began).count();
    bool moved = true;
    for (const StepStatistics& row : simulation.take_statistics()) {
      result.iterations += row.iterations;
      result.caps += row.reason != StopReason::tolerance;
      result.rises += row.energy_rises;
      result.estimate = std::max(result.estimate, row.energy_error);
      moved = row.reason != StopReason::floor;
    }
    if (!sampled || !moved) continue;
    result.error = std::max(result.error, judge.error(start, simulation.positions()));
    ++result.judged;
  }
  result.ms /= result.steps, result.iterations /= result.steps;
  return result;
}

} // namespace

int main(int argc, char** argv) try {
  if (argc > 1 && argv[1][0] == '-') {
    fmt::print(
        "table1 [FOLDER [SCENES [NAME ...]]]: time of the scenes in SCENES, bench/table1 unless given; "
        "writes FOLDER/table1.csv\n");
    return std::string(argv[1]) == "--help" ? 0 : 2;
  }
  const std::filesystem::path folder = argc > 1 ? argv[1] : ".", scenes = argc > 2 ? argv[2] : "bench/table1";
  const std::vector<std::string> only(argv + std::min(argc, 3), argv + argc);
  std::filesystem::create_directories(folder);
  std::ofstream csv(folder / "table1.csv");
  csv << "scene,particles,time_step,method,steps,iterations,ms,energy_error,paper_iterations,paper_ms,"
         "ratio\n";
  fmt::print("{:<10}{:>10}{:>8}  {:<19}{:>11}{:>9}{:>13}{:>13}{:>10}{:>8}\n", "scene", "particles", "step s",
             "method", "iterations", "ms", "error worst", "not reached", "paper ms", "ratio");
  std::fflush(stdout);
  double product = 1;
  int count = 0;
  for (const Row& row : rows) {
    if (!only.empty() && std::find(only.begin(), only.end(), row.name) == only.end()) continue;
    const Result r = measure(scenes / fmt::format("{}.toml", row.name));
    const double ratio = row.paper_ms / r.ms;
    product *= ratio, ++count;
    fmt::print("{:<10}{:>10}{:>8.2g}  {:<19}{:>11.1f}{:>9.2f}{:>13.1e}{:>10}/{}{:>10.0f}{:>8.1f}\n", row.name,
               r.particles, r.step, r.method, r.iterations, r.ms, r.error, r.caps, r.steps, row.paper_ms,
               ratio);
    std::fflush(stdout);
    csv << fmt::format("{},{},{},{},{},{},{},{},{},{},{}\n", row.name, r.particles, r.step, r.method, r.steps,
                       r.iterations, r.ms, r.error, row.paper_iterations, row.paper_ms, ratio);
  }
  if (count > 0) fmt::print("geometric mean of the ratios: {:.1f}\n", std::pow(product, 1.0 / count));
  return 0;
} catch (const Error& error) {
  fmt::print(stderr, "table1: {}\n", error.what());
  return static_cast<int>(error.code());
}
