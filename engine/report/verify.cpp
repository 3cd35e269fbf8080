// Runs the master and the others, and compares.
#include "engine/report/verify.h"

#include "engine/core/error.h"
#include "engine/device/replay.h"
#include "engine/solver/simulation.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <random>
#include <set>

namespace pliant {

namespace {

using Clock = std::chrono::steady_clock;

struct Fields {
  std::vector<Vector3> position, velocity; ///< m, m/s
};
struct Stretch {
  Snapshot start;
  unsigned steps = 0; ///< that it is judged after
  Fields end;         ///< of the master, then
};

/// Prints how far a device is, at most every few seconds.
class Steps {
public:
  Steps(const VerifyOptions& options, std::string name, unsigned total)
      : options_(options), name_(std::move(name)), total_(total), start_(Clock::now()), last_(start_) {}
  void operator()() {
    ++done_;
    const Clock::time_point now = Clock::now();
    if (std::chrono::duration<double>(now - last_).count() < 5) return;
    last_ = now;
    const double spent = std::chrono::duration<double>(now - start_).count();
    options_.say(fmt::format("{}: {} of {} steps, about {:.0f} s left", name_, done_, total_,
                             spent / done_ * (total_ - done_)));
  }
  void end() {
    options_.say(fmt::format("{}: {} steps in {:.1f} s", name_, done_,
                             std::chrono::duration<double>(Clock::now() - start_).count()));
  }

private:
  const VerifyOptions& options_;
  std::string name_;
  unsigned total_, done_ = 0;
  Clock::time_point start_, last_;
};

class Verification {
public:
  Verification(const Scene& scene, const VerifyOptions& options)
      : scene_(scene), options_(options), every_(stretch_length(options, scene)), model_(assemble(scene)) {
    plain_.statistics = false;
    for (const BodyModel& body : model_.bodies) {
      Vector3 low = Vector3::Constant(1e300), high = -low;
      for (std::uint32_t i = body.first; i < body.first + body.count; ++i) {
        low = low.cwiseMin(model_.reference[i]);
        high = high.cwiseMax(model_.reference[i]);
      }
      sizes_.push_back(std::max((high - low).norm(), model_.spacing));
    }
  }

  VerifyReport run() {
    report_.scene = scene_.name;
    report_.particles = model_.count();
    report_.bonds = model_.bonds.count();
    report_.iterations = scene_.solver.fixed_iterations ? scene_.solver.iterations : 0;
    options_.say(fmt::format("{}: {} particles, {} bonds; {} steps {}, stretches of {}", scene_.name,
                             report_.particles, report_.bonds, options_.steps,
                             report_.iterations > 0 ? fmt::format("of {} iterations", report_.iterations)
                                                    : "that are solved",
                             every_));
    master();
    const std::vector<Fields> on_cpu = contender("openmp float", {"openmp"}, nullptr);
    for (const DeviceListing& listing : list_devices()) {
      if (listing.backend != "gl") continue;
      if (!listing.usable) {
        report_.skipped.push_back(fmt::format("gl ({}): {}", listing.name, listing.missing));
        options_.say("skipped: " + report_.skipped.back());
        continue;
      }
      const std::string name = fmt::format("gl:{}", listing.index);
      options_.say(
          fmt::format("{} is {}{}", name, listing.name, listing.software ? " (software: slow)" : ""));
      contender(name, {name}, &on_cpu);
      if (options_.kernels) kernel_by_kernel(name);
    }
    for (const Precision precision : {Precision::double_precision, Precision::single_precision}) {
      const std::string name = precision == Precision::double_precision ? "openmp double" : "openmp float";
      report_.threads.push_back(
          {name, short_run({"openmp", precision, 1}), short_run({"openmp", precision, 2})});
    }
    return std::move(report_);
  }

private:
  static std::unique_ptr<Device> open(const DeviceRequest& request) { return open_device(request); }

  void master() {
    const DeviceRequest request{"openmp", Precision::double_precision};
    const std::unique_ptr<Device> device = open(request), second = scene_.flows() ? open(request) : nullptr;
    Simulation simulation(*device, scene_, model_, plain_);
    std::unique_ptr<Simulation> rounded;
    if (second) rounded = std::make_unique<Simulation>(*second, scene_, model_, plain_);
    duration_ = every_ * simulation.time_step();
    Steps steps(options_, master_name, (rounded ? 2 : 1) * options_.steps + every_);
    std::string hash;
    for (unsigned first = 0; first < options_.steps; first += every_) {
      Stretch stretch{simulation.snapshot(), every_, {}};
      std::vector<Fields> path; // of a stretch that may end before its last step
      for (unsigned k = 0; k < every_; ++k) {
        simulation.step(), steps();
        if (rounded || k + 1 == every_) path.push_back(fields(simulation));
      }
      stretch.end = end_ = path.back();
      if (rounded) shorten(stretch, path, *rounded, steps);
      if (first == 0) hash = simulation.hash();
      stretches_.push_back(std::move(stretch));
    }
    report_.run_to_run.push_back({master_name, hash, short_run(request, &steps)});
    steps.end();
  }

  static Fields fields(Simulation& simulation) { return {simulation.positions(), simulation.velocities()}; }

  /// Lets a stretch end where the matter itself makes too much of a rounding of its start.
  void shorten(Stretch& stretch, const std::vector<Fields>& path, Simulation& rounded, Steps& steps) {
    Snapshot start = stretch.start;
    for (std::size_t i = 0; i < start.position.size(); ++i) {
      const auto off = [&] { // of a number the size of half the body: -1 to 1 roundings of it
        return 0x1p-25 * sizes_[model_.body[i]] * (0x1p-52 * static_cast<double>(random_() >> 11) - 1);
      };
      for (int a = 0; a < (model_.dimension == 2 ? 2 : 3); ++a) start.position[i][a] += off();
    }
    rounded.restore(start);
    std::vector<double> growth;
    for (const Fields& master : path) {
      rounded.step(), steps();
      VerifyReport::Pair pair;
      add(pair, master, fields(rounded), stretch);
      growth.push_back(std::max(pair.fields[0].max_relative, pair.fields[1].max_relative));
    }
    stretch.steps = judged_steps(growth);
    stretch.end = path[stretch.steps - 1];
    VerifyReport::Stretches& all = report_.stretches;
    all.shortest = all.count > 0 ? std::min(all.shortest, stretch.steps) : stretch.steps;
    ++all.count;
    if (stretch.steps < every_) ++all.shortened;
    all.growth = std::max(all.growth, growth.back());
  }

  /// Returns the fields at the end of each stretch. `on_cpu`: those of the CPU in the same precision, to be
  /// compared with.
  std::vector<Fields> contender(const std::string& name, const DeviceRequest& request,
                                const std::vector<Fields>* on_cpu) {
    const std::unique_ptr<Device> device = open(request);
    Simulation simulation(*device, scene_, model_, plain_);
    Steps steps(options_, name, 2 * options_.steps + every_);
    std::string hash;
    for (unsigned k = 1; k <= options_.steps; ++k) {
      simulation.step(), steps();
      if (k == every_) hash = simulation.hash();
    }
    VerifyReport::Pair unbroken{master_name, name, options_.steps, 1, {}};
    add(unbroken, end_, fields(simulation), stretches_.back());
    report_.unbroken.push_back(std::move(unbroken));

    VerifyReport::Pair with_master{master_name, name, every_, 0, {}};
    VerifyReport::Pair with_cpu{"openmp float", name, every_, 0, {}};
    std::vector<Fields> ends;
    for (const Stretch& stretch : stretches_) {
      simulation.restore(stretch.start);
      for (unsigned k = 0; k < stretch.steps; ++k) simulation.step(), steps();
      ends.push_back(fields(simulation));
      add(with_master, stretch.end, ends.back(), stretch), ++with_master.stretches;
      if (on_cpu) add(with_cpu, (*on_cpu)[ends.size() - 1], ends.back(), stretch), ++with_cpu.stretches;
    }
    report_.pairs.push_back(std::move(with_master));
    if (on_cpu) report_.pairs.push_back(std::move(with_cpu));
    report_.run_to_run.push_back({name, hash, short_run(request, &steps)});
    steps.end();
    return ends;
  }

  /// Hash after a stretch from the scene's start, on a device of its own.
  std::string short_run(const DeviceRequest& request, Steps* steps = nullptr) const {
    const std::unique_ptr<Device> device = open(request);
    Simulation simulation(*device, scene_, model_, plain_);
    for (unsigned k = 0; k < every_; ++k) {
      simulation.step();
      if (steps) (*steps)();
    }
    return simulation.hash();
  }

  /// One step from the last start, when whatever can touch does, with all that a run would compute.
  void kernel_by_kernel(const std::string& name) {
    VerifyReport::Kernels row{name, 0, 0, {}};
    options_.say(name + ": one step, each kernel replayed on the CPU");
    DeviceRequest request{name};
    request.replay = true;
    const std::unique_ptr<Device> device = open(request);
    PlanRequest everything;
    everything.fields = scene_.output.fields;
    Simulation simulation(*device, scene_, model_, everything);
    simulation.restore(stretches_.back().start);
    try {
      simulation.step();
      device->finish();
    } catch (const Error& error) {
      if (error.code() != ExitCode::internal) throw;
      row.mismatch = error.what();
    }
    std::set<std::string> names;
    for (const std::string& variant : device->kernels_prepared())
      names.insert(variant.substr(0, variant.find('[')));
    row.compared = names.size();
    row.ties = replay_ties(*device);
    report_.kernels.push_back(std::move(row));
  }

  void add(VerifyReport::Pair& pair, const Fields& a, const Fields& b, const Stretch& stretch) const {
    // What hardly moves is not judged by its own speed: one that crosses a hundredth of the body within a
    // stretch is the least that velocities are compared with.
    double speed = 0.01 * *std::min_element(sizes_.begin(), sizes_.end()) / duration_;
    for (const Vector3& v : stretch.start.velocity) speed = std::max(speed, v.norm());
    for (const Vector3& v : stretch.end.velocity) speed = std::max(speed, v.norm());
    if (pair.fields.empty()) pair.fields = {{"position", 0, 0}, {"velocity", 0, 0}};
    add(pair.fields[0], a.position, b.position, [&](std::size_t i) { return sizes_[model_.body[i]]; });
    add(pair.fields[1], a.velocity, b.velocity, [&](std::size_t) { return speed; });
  }

  template <class Scale>
  static void add(FieldDifference& field, const std::vector<Vector3>& a, const std::vector<Vector3>& b,
                  Scale scale) {
    std::vector<double> relative(a.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      relative[i] = (a[i] - b[i]).norm() / scale(i);
      if (!std::isfinite(relative[i])) relative[i] = std::numeric_limits<double>::infinity();
    }
    const auto middle = relative.begin() + static_cast<std::ptrdiff_t>(relative.size() / 2);
    std::nth_element(relative.begin(), middle, relative.end());
    field.median_relative = std::max(field.median_relative, *middle);
    field.max_relative = std::max(field.max_relative, *std::max_element(relative.begin(), relative.end()));
  }

  static constexpr const char* master_name = "openmp double";
  const Scene& scene_;
  const VerifyOptions& options_;
  unsigned every_; ///< steps of a stretch
  Model model_;
  PlanRequest plain_;
  std::vector<double> sizes_; ///< m; diagonal of each body's box at rest
  double duration_ = 0;       ///< s; of a stretch
  std::vector<Stretch> stretches_;
  Fields end_;                    ///< of the master, after all steps
  std::mt19937_64 random_{20171}; ///< the same in each verification
  VerifyReport report_;
};

} // namespace

unsigned stretch_length(const VerifyOptions& options, const Scene& scene) {
  return options.every > 0 ? options.every : scene.flows() ? 5 : 10;
}

unsigned verify_iterations(const VerifyOptions& options, const Scene& scene) {
  const bool bonded = std::any_of(scene.materials.begin(), scene.materials.end(),
                                  [](const Material& material) { return material.bonded(); });
  return std::max(options.iterations, bonded ? verify_bonded : 0u);
}

unsigned judged_steps(const std::vector<double>& growth) {
  std::size_t steps = growth.size();
  while (steps > 1 && !(growth[steps - 1] <= verify_growth)) --steps;
  return static_cast<unsigned>(steps);
}

bool VerifyReport::Pair::within() const {
  return std::all_of(fields.begin(), fields.end(),
                     [](const FieldDifference& field) { return field.max_relative <= verify_limit; });
}

bool VerifyReport::run_to_run_identical() const {
  return std::all_of(run_to_run.begin(), run_to_run.end(), [](const Hashes& one) { return one.identical(); });
}

bool VerifyReport::threads_identical() const {
  return std::all_of(threads.begin(), threads.end(), [](const Hashes& one) { return one.identical(); });
}

bool VerifyReport::good() const {
  return run_to_run_identical() && threads_identical() &&
         std::all_of(pairs.begin(), pairs.end(), [](const Pair& pair) { return pair.within(); }) &&
         std::all_of(kernels.begin(), kernels.end(), [](const Kernels& row) { return row.mismatch.empty(); });
}

VerifyReport verify_scene(Scene scene, const VerifyOptions& options) {
  const unsigned every = stretch_length(options, scene);
  if (options.steps == 0 || options.steps % every != 0)
    throw Error(ExitCode::usage,
                fmt::format("{} steps are no whole number of stretches of {}: choose --steps as a multiple "
                            "of --every",
                            options.steps, every));
  std::string& method = scene.solver.method;
  if (method == "auto") method = "chebyshev"; // sweeps without a decision between them
  scene.solver.fixed_iterations = method != "newton" && method != "lbfgs" && method != "direct";
  if (scene.solver.fixed_iterations) {
    scene.solver.iterations = verify_iterations(options, scene);
  } else {
    scene.solver.tolerance = verify_tolerance;
    scene.solver.energy_tolerance.reset();
  }
  return Verification(scene, options).run();
}

} // namespace pliant
