// Runs the problems of the sweep: on the CPU several at a time, one thread each; then on GL, one after
// another.
#include "engine/report/stability.h"

#include "engine/core/error.h"
#include "engine/plan/method.h"
#include "engine/report/progress.h"
#include "engine/solver/simulation.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <mutex>
#include <optional>
#include <thread>

namespace pliant {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

struct Backend {
  std::string name;
  DeviceRequest request;
  bool software = false;
  bool gl() const { return request.backend != "openmp"; }
};

/// A run's positions after its first step and at its end.
struct Track {
  std::vector<Vector3> first, end; ///< m, world; empty where they are not finite
};

double rms_difference(const std::vector<Vector3>& a, const std::vector<Vector3>& b) {
  if (a.empty() || a.size() != b.size()) return std::nan("");
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(a.size()));
}

void set_start(Simulation& simulation, const StabilitySetup& setup) {
  Snapshot state = simulation.snapshot();
  state.position = setup.position;
  state.velocity = setup.velocity;
  simulation.restore(state);
}

/// One run. Fills the cell and returns where the particles were.
Track run_cell(Device& device, const StabilitySetup& setup, unsigned steps, StabilityCell& cell) {
  Track track;
  const Clock::time_point start = Clock::now();
  StabilityWatch watch(setup, steps);
  cell.recovery_wanted = setup.wanted != Wanted::nothing;
  try {
    Simulation simulation(device, setup.scene, setup.model);
    const Method& method = simulation.plan().method;
    cell.resolved = method.preconditioner.empty() ? method.name : method.name + ", " + method.preconditioner;
    cell.stiffness_number = simulation.stiffness_number();
    double first_energy = simulation.elastic_energy(setup.position), most_energy = first_energy;
    for (std::size_t i = 0; i < setup.velocity.size(); ++i)
      first_energy += setup.model.mass[i] / 2 * setup.velocity[i].squaredNorm();
    set_start(simulation, setup);
    for (unsigned n = 1; n <= steps; ++n) {
      simulation.step();
      const std::vector<Vector3> positions = simulation.positions();
      for (const StepStatistics& row : simulation.take_statistics()) {
        cell.iterations += row.iterations;
        cell.restarts += row.restarts;
        cell.at_cap += row.reason == StopReason::cap;
        most_energy = std::max(most_energy, row.kinetic_energy + row.elastic_energy);
      }
      if (!watch.after(n, simulation.time_step(), positions)) break;
      if (n == 1) track.first = positions;
      if (n == steps) track.end = positions;
    }
    cell.energy = first_energy > 0 ? most_energy / first_energy : 0;
    watch.judge(cell);
  } catch (const Error& error) {
    cell.message = error.what();
    if (error.code() == ExitCode::usage) {
      cell.refused = true;
    } else {
      cell.finite = cell.bounded = cell.recovered = false; // given up: it diverged, or it is our fault
    }
  }
  cell.seconds = seconds_since(start);
  return track;
}

class Sweep {
public:
  Sweep(const Scene& scene, const StabilityOptions& options)
      : options_(options), problems_(stability_problems(scene, options)) {
    check_methods();
    if (!options.only.empty())
      std::erase_if(problems_, [&](const auto& p) { return p.name.find(options.only) == std::string::npos; });
    if (problems_.empty())
      throw Error(ExitCode::usage,
                  fmt::format("no problem's name contains \"{}\"; without --only all of them are "
                              "run and listed",
                              options.only));
    report_.scene = scene.name;
    report_.steps = options.steps;
    report_.iterations = options.iterations;
    find_backends();
  }

  StabilityReport run() {
    results_.resize(problems_.size());
    tracks_.resize(problems_.size());
    on_cpu();
    for (const Backend& backend : backends_)
      if (backend.gl()) on_gl(backend);
    for (std::vector<StabilityCell>& cells : results_)
      for (StabilityCell& cell : cells) report_.cells.push_back(std::move(cell));
    if (skipped_ > 0)
      report_.left_out.push_back(
          fmt::format("{} problems: {:g} minutes were over", skipped_.load(), options_.minutes));
    report_.seconds = seconds_since(start_);
    return std::move(report_);
  }

private:
  void check_methods() const {
    for (const std::string& name : options_.methods) {
      const auto known = method_names();
      if (std::find(known.begin(), known.end(), name) == known.end())
        throw Error(ExitCode::usage, fmt::format("there is no method \"{}\"; there are {}", name,
                                                 fmt::join(known.begin(), known.end(), ", ")));
    }
  }

  void find_backends() {
    std::vector<Backend> all{{"openmp-float", {"openmp", Precision::single_precision, 1}},
                             {"openmp-double", {"openmp", Precision::double_precision, 1}}};
    for (const DeviceListing& listing : list_devices()) {
      if (listing.backend != "gl") continue;
      const std::string name = fmt::format("gl:{}", listing.index);
      if (listing.usable)
        all.push_back({name, {name}, listing.software});
      else if (options_.backends.empty())
        report_.left_out.push_back(fmt::format("gl ({}): {}", listing.name, listing.missing));
    }
    if (options_.backends.empty()) {
      backends_ = all;
      return;
    }
    for (const std::string& name : options_.backends) {
      const auto found = std::find_if(all.begin(), all.end(), [&](const Backend& b) {
        return b.name == name || (name == "gl" && b.name == "gl:0");
      });
      if (found == all.end()) {
        std::string names;
        for (const Backend& backend : all) names += (names.empty() ? "" : ", ") + backend.name;
        throw Error(ExitCode::no_device, fmt::format("no backend \"{}\" here; there are {}", name, names));
      }
      backends_.push_back(*found);
    }
  }

  bool late() const { return options_.minutes > 0 && seconds_since(start_) > 60 * options_.minutes; }

  void say_progress(std::size_t done, std::size_t all, const std::string& what, Clock::time_point since) {
    const std::lock_guard lock(mutex_);
    if (seconds_since(said_) < 5 && done < all) return;
    said_ = Clock::now();
    const double spent = seconds_since(since);
    options_.say(
        fmt::format("{}: {} of {} problems, about {} left", what, done, all,
                    clock_text(spent / static_cast<double>(done) * static_cast<double>(all - done))));
  }

  void on_cpu() {
    std::vector<const Backend*> mine;
    for (const Backend& backend : backends_)
      if (!backend.gl()) mine.push_back(&backend);
    std::atomic<std::size_t> next{0}, done{0};
    const Clock::time_point since = Clock::now();
    std::exception_ptr failure;
    const auto work = [&] {
      for (std::size_t k = next++; k < problems_.size(); k = next++) {
        if (late()) {
          if (!mine.empty()) ++skipped_;
          continue;
        }
        try {
          solve(k, mine);
        } catch (...) {
          const std::lock_guard lock(mutex_);
          failure = std::current_exception();
          return;
        }
        say_progress(++done, problems_.size(), "on the CPU", since);
      }
    };
    const unsigned jobs = options_.jobs ? options_.jobs : std::max(std::thread::hardware_concurrency(), 1u);
    std::vector<std::jthread> workers;
    for (unsigned j = 1; j < jobs; ++j) workers.emplace_back(work);
    work();
    workers.clear(); // joins
    if (failure) std::rethrow_exception(failure);
  }

  void on_gl(const Backend& backend) {
    std::vector<std::size_t> mine;
    for (std::size_t k = 0; k < problems_.size(); ++k)
      if (options_.full || !backend.software || problems_[k].on_gl) mine.push_back(k);
    const Clock::time_point since = Clock::now();
    const std::unique_ptr<Device> device = open_device(backend.request);
    std::size_t done = 0;
    for (std::size_t k : mine) {
      if (late()) {
        ++skipped_;
        continue;
      }
      solve(k, {&backend}, device.get());
      say_progress(++done, mine.size(), "on " + backend.name, since);
    }
  }

  /// All cells of a problem on these backends. On the CPU first its reference.
  void solve(std::size_t k, const std::vector<const Backend*>& backends, Device* opened = nullptr) {
    const StabilityProblem& problem = problems_[k];
    StabilityCell blank;
    blank.name = problem.name;
    blank.young = problem.young, blank.poisson = problem.poisson, blank.time_step = problem.time_step;
    blank.map = problem.map;
    StabilitySetup setup;
    std::string refusal;
    try {
      setup = problem.build();
      note_particles(setup.model.count());
    } catch (const Error& error) {
      if (error.code() != ExitCode::usage) throw;
      refusal = error.what();
    }
    if (!opened && refusal.empty()) tracks_[k] = reference(problem, setup);
    for (const Backend* backend : backends) {
      std::map<std::string, StabilityCell> solved; // by what "auto" resolves to: the same run
      for (const std::string& method : options_.methods) {
        StabilityCell cell = blank;
        cell.method = method;
        cell.backend = backend->name;
        if (!refusal.empty()) {
          cell.refused = true;
          cell.message = refusal;
          results_[k].push_back(cell);
          continue;
        }
        setup.scene.solver.method = method;
        setup.scene.solver.iterations = problem.iterations;
        const std::string key = resolved(setup);
        if (const auto known = solved.find(key); known != solved.end()) {
          cell = known->second;
          cell.method = method;
        } else {
          const std::unique_ptr<Device> own = opened ? nullptr : open_device(backend->request);
          const Track track = run_cell(opened ? *opened : *own, setup, problem.steps, cell);
          cell.first_distance = rms_difference(track.first, tracks_[k].first) / setup.model.spacing;
          cell.end_distance = rms_difference(track.end, tracks_[k].end) / setup.model.spacing;
          solved[key] = cell;
        }
        results_[k].push_back(cell);
      }
    }
  }

  /// What the solve depends on of the method; of one that is refused, its name.
  static std::string resolved(const StabilitySetup& setup) {
    if (setup.model.count() == 0) return setup.scene.solver.method;
    try {
      const Method method = choose_method(setup.scene, setup.model);
      return method.name + "/" + method.preconditioner;
    } catch (const Error&) {
      return setup.scene.solver.method;
    }
  }

  /// Newton's method in double precision, far below the tolerance of any cell.
  static Track reference(const StabilityProblem& problem, StabilitySetup& setup) {
    const SolverSettings settings = setup.scene.solver;
    setup.scene.solver.method = setup.scene.materials.front().law == "projective" ? "chebyshev" : "newton";
    setup.scene.solver.tolerance = 1e-9;
    setup.scene.solver.iterations = 1000;
    DeviceRequest request{"openmp", Precision::double_precision, 1};
    StabilityCell cell;
    const std::unique_ptr<Device> device = open_device(request);
    const Track track = run_cell(*device, setup, std::min(problem.steps, 60u), cell);
    setup.scene.solver = settings;
    return track;
  }

  void note_particles(std::size_t count) {
    const std::lock_guard lock(mutex_);
    report_.particles = std::max(report_.particles, count);
  }

  const StabilityOptions& options_;
  std::vector<StabilityProblem> problems_;
  std::vector<Backend> backends_;
  std::vector<std::vector<StabilityCell>> results_; ///< of each problem
  std::vector<Track> tracks_;                       ///< of each problem's reference
  StabilityReport report_;
  std::atomic<std::size_t> skipped_{0};
  std::mutex mutex_;
  Clock::time_point start_ = Clock::now(), said_ = start_;
};

} // namespace

std::size_t StabilityReport::count(bool (*of)(const StabilityCell&)) const {
  return static_cast<std::size_t>(std::count_if(cells.begin(), cells.end(), of));
}
std::size_t StabilityReport::non_finite() const {
  return count([](const StabilityCell& cell) { return !cell.finite; });
}
std::size_t StabilityReport::unbounded() const {
  return count([](const StabilityCell& cell) { return cell.finite && !cell.bounded; });
}
std::size_t StabilityReport::unrecovered() const {
  return count(
      [](const StabilityCell& cell) { return cell.bounded && cell.recovery_wanted && !cell.recovered; });
}

StabilityReport sweep_stability(const Scene& scene, const StabilityOptions& options) {
  if (scene.flows())
    throw Error(ExitCode::usage, scene.file.string() +
                                     ": a fluid has none of the methods that are swept here; "
                                     "the sweep is of a scene's first body, an elastic one");
  return Sweep(scene, options).run();
}

} // namespace pliant
