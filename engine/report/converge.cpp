// Solves the same step with every method on every backend, with a clock beside it.
#include "engine/report/converge.h"

#include "engine/core/error.h"
#include "engine/plan/method.h"
#include "engine/report/converge_problem.h"
#include "engine/solver/stationary.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <map>
#include <set>

namespace pliant {

namespace {

using Clock = std::chrono::steady_clock;

constexpr double reached = 1e-6;        ///< all errors: a series need go no further
constexpr double repeat_below = 4;      ///< s: longer passes are timed once
constexpr double repeats_seconds = 1.5; ///< for all timed passes of a series
constexpr unsigned passes_wanted = 5;
constexpr unsigned cap = 100'000'000; ///< iterations
constexpr unsigned patience = 300;    ///< iterations without progress, at least, before a series has ended

struct Variant {
  std::string method, preconditioner;
  std::string name() const { return preconditioner.empty() ? method : method + "+" + preconditioner; }
};

/// Quick ones first: the slow ones then share all the time that is left.
std::vector<Variant> all_variants() {
  std::vector<Variant> variants;
  std::vector<std::string> plain;
  for (const std::string name : method_names()) {
    if (name == "auto") continue;
    if (name != "newton" && name != "lbfgs") {
      plain.push_back(name);
      continue;
    }
    for (const std::string preconditioner : preconditioner_names())
      if (preconditioner != "auto" && (name == "lbfgs" || preconditioner != "direct"))
        variants.push_back({name, preconditioner});
  }
  std::reverse(variants.begin(), variants.end());
  std::sort(plain.begin(), plain.end(), [](const std::string& a, const std::string& b) {
    const auto rank = [](const std::string& name) {
      return name == "direct" ? 0 : name == "chebyshev" ? 1 : name == "jacobi" ? 2 : 3;
    };
    return rank(a) < rank(b);
  });
  for (const std::string& name : plain) variants.push_back({name, ""});
  return variants;
}

std::vector<Variant> wanted_variants(const std::vector<std::string>& only) {
  std::vector<Variant> all = all_variants();
  if (only.empty()) return all;
  std::vector<Variant> wanted;
  for (const std::string& name : only) {
    const std::size_t before = wanted.size();
    for (const Variant& variant : all)
      if (variant.method == name || variant.name() == name) wanted.push_back(variant);
    if (wanted.size() > before) continue;
    std::vector<std::string> names;
    for (const Variant& variant : all) {
      if (std::find(names.begin(), names.end(), variant.method) == names.end())
        names.push_back(variant.method);
      if (!variant.preconditioner.empty()) names.push_back(variant.name());
    }
    throw Error(ExitCode::usage, fmt::format("no method \"{}\"; there are {}", name, fmt::join(names, ", ")));
  }
  return wanted;
}

struct Place {
  DeviceRequest request{};
  std::string backend, precision;
  bool software = false;
};

std::vector<Place> wanted_places(const ConvergeOptions& options, std::vector<std::string>& left_out) {
  const auto asked = [&](const std::string& name) {
    return options.backends.empty() ||
           std::find(options.backends.begin(), options.backends.end(), name) != options.backends.end();
  };
  for (const std::string& name : options.backends)
    if (name != "openmp" && name != "gl" && name.rfind("gl:", 0) != 0)
      throw Error(ExitCode::usage, "unknown backend '" + name + "'; there are openmp, gl and gl:N");
  std::vector<Place> places;
  if (asked("openmp")) {
    const DeviceRequest single{"openmp", Precision::single_precision, options.threads};
    places.push_back(Place{double_precision(options.threads), "openmp", "double", false});
    places.push_back(Place{single, "openmp", "float", false});
  }
  std::set<std::string> found;
  for (const DeviceListing& listing : list_devices()) {
    if (listing.backend != "gl") continue;
    const std::string name = fmt::format("gl:{}", listing.index);
    found.insert(name);
    if (!asked(name) && !(asked("gl") && (listing.index == 0 || options.backends.empty()))) continue;
    if (!listing.usable)
      left_out.push_back(fmt::format("{} ({}): {}", name, listing.name, listing.missing));
    else {
      DeviceRequest request;
      request.backend = name;
      places.push_back(Place{request, name, "float", listing.software});
    }
  }
  for (const std::string& name : options.backends)
    if (name.rfind("gl:", 0) == 0 && !found.count(name))
      throw Error(ExitCode::no_device, fmt::format("there is no device {}; see `pliant doctor`", name));
  return places;
}

/// 1 2 3 4 5 6 8 10 12 ...: each about a fifth more than the last.
unsigned sample_after(unsigned n) {
  return n + std::max(1u, n / 5);
}

/// The largest of a point's errors that are numbers; energies go as squares, and to 1e-8.
double worst(const ConvergePoint& point) {
  const double rest = std::max(point.position_rms, point.residual);
  return 100 * point.energy_error > rest ? 100 * point.energy_error : rest;
}

/// Wall time of a solve, stopped while errors are computed.
class Watch {
public:
  explicit Watch(Device& device) : device_(device) {}
  void start() {
    device_.finish();
    since_ = Clock::now();
  }
  void stop() {
    device_.finish();
    spent_ += std::chrono::duration<double, std::milli>(Clock::now() - since_).count();
  }
  double ms() const { return spent_; }

private:
  Device& device_;
  Clock::time_point since_;
  double spent_ = 0;
};

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
}

/// One series: a judged pass, then passes for the clock alone.
class Racer {
public:
  Racer(Simulation& simulation, StepProblem& problem, ConvergeSeries& series, unsigned least_patience)
      : simulation_(simulation), problem_(problem), series_(series),
        patience_(std::max(patience, least_patience)) {}

  void run(double limit) {
    const double spent = judged_pass(limit);
    time_again(spent);
  }

private:
  void begin(Watch& watch) {
    simulation_.restore(problem_.start());
    watch.start();
    simulation_.begin_solving();
    watch.stop();
  }

  void add(unsigned iteration, double ms) {
    ConvergePoint point = problem_.errors(simulation_.iterate_positions());
    point.iteration = iteration, point.ms = ms;
    const double errors[] = {point.residual, point.energy_error, point.position_rms};
    for (int e = 0; e < 3; ++e)
      if (errors[e] < 0.999 * least_[e]) least_[e] = errors[e], progress_ = iteration;
    series_.points.push_back(point);
  }

  /// Returns seconds on the clock.
  double judged_pass(double limit) {
    Watch watch(simulation_.device());
    begin(watch);
    add(0, watch.ms());
    unsigned next = 1;
    watch.start();
    for (unsigned n = 1;; ++n) {
      const bool look = n == next, ended = simulation_.iterate(look);
      if (!look && !ended) continue;
      watch.stop();
      add(n, watch.ms());
      const ConvergePoint& point = series_.points.back();
      next = sample_after(n);
      const double seconds = watch.ms() / 1000, ahead = seconds / n * (next - n);
      if (!std::isfinite(point.position_rms))
        series_.end = "not finite";
      else if (worst(point) <= reached)
        series_.end = "1e-6";
      else if (ended)
        series_.end = "no descent left that its precision can tell";
      else if (n >= 2 * progress_ && n >= progress_ + patience_)
        series_.end = "floor: no progress over as many iterations again";
      else if (seconds + ahead > limit)
        series_.end = fmt::format("time: {:.3g} s", limit);
      if (!series_.end.empty()) return seconds;
      watch.start();
    }
  }

  void time_again(double spent) {
    if (spent > repeat_below) return;
    std::vector<std::vector<double>> times(series_.points.size());
    double total = 0;
    unsigned passes = 0;
    while (passes == 0 || (passes < passes_wanted && total + spent < repeats_seconds)) {
      Watch watch(simulation_.device());
      begin(watch);
      times[0].push_back(watch.ms());
      watch.start();
      unsigned n = 0;
      for (std::size_t p = 1; p < series_.points.size(); ++p) {
        const unsigned stop = series_.points[p].iteration;
        while (n < stop) {
          ++n;
          simulation_.iterate(n == stop);
        }
        watch.stop();
        times[p].push_back(watch.ms());
        watch.start();
      }
      total += watch.ms() / 1000;
      ++passes;
    }
    for (std::size_t p = 0; p < times.size(); ++p) series_.points[p].ms = median(times[p]);
    series_.passes = passes;
  }

  Simulation& simulation_;
  StepProblem& problem_;
  ConvergeSeries& series_;
  double least_[3] = {1e300, 1e300, 1e300};
  unsigned progress_ = 0; ///< iteration of the last
  unsigned patience_;     ///< iterations without progress
};

ConvergeSeries race(const Variant& variant, const Place& place, Device& device, const Scene& scene,
                    const Model& model, StepProblem& problem, double limit) {
  Scene raced = scene;
  raced.solver.method = variant.method;
  if (!variant.preconditioner.empty()) raced.solver.preconditioner = variant.preconditioner;
  raced.solver.iterations = cap;
  raced.solver.fixed_iterations = true;
  // As a run of the scene would, for its own cap; without one it would assume the largest radius there is,
  // whose oscillation outlasts the patience below.
  if (variant.method == "chebyshev" && !raced.solver.spectral_radius)
    raced.solver.spectral_radius =
        1 - chebyshev_gap(choose_method(raced, model).stiffness_number, !scene.boundaries.empty(),
                          scene.solver.tolerance, scene.solver.iterations);
  ConvergeSeries series;
  series.method = variant.method, series.preconditioner = variant.preconditioner;
  series.backend = place.backend, series.precision = place.precision, series.software = place.software;
  series.device = device.info().name;
  Watch watch(device);
  watch.start();
  PlanRequest plain;
  plain.statistics = false;
  Simulation simulation(device, raced, model, plain);
  simulation.restore(problem.start());
  simulation.begin_solving();
  simulation.iterate(true); // what a method prepares when it is first needed
  watch.stop();
  series.setup_ms = watch.ms();
  Racer(simulation, problem, series, variant.method == "chebyshev" ? 2 * scene.solver.iterations : 0)
      .run(limit);
  return series;
}

} // namespace

std::string ConvergeSeries::variant() const {
  return preconditioner.empty() ? method : method + "+" + preconditioner;
}

std::string ConvergeSeries::place() const {
  return backend == "openmp" ? backend + " " + precision : backend;
}

std::optional<double> time_to(const ConvergeSeries& series, double ConvergePoint::*error, double limit) {
  std::optional<double> ms;
  for (const ConvergePoint& point : series.points) {
    if (!(point.*error <= limit))
      ms.reset();
    else if (!ms)
      ms = point.ms;
  }
  return ms;
}

ConvergeReport converge_step(const Scene& scene, const ConvergeOptions& options) {
  const auto began = Clock::now();
  const auto elapsed = [began] { return std::chrono::duration<double>(Clock::now() - began).count(); };
  ConvergeReport report;
  const std::vector<Variant> variants = wanted_variants(options.only);
  const std::vector<Place> places = wanted_places(options, report.left_out);
  if (scene.bodies.empty()) throw Error(ExitCode::usage, "the scene has no particles: give it a [[body]]");
  const Model model = assemble(scene);
  StepProblem problem(scene, model, options);
  report.scene = scene.name;
  report.processor = problem.device().name;
  report.threads = problem.device().threads;
#ifdef NDEBUG
  report.build = "release, " __VERSION__;
#else
  report.build = "DEBUG, " __VERSION__;
#endif
  report.particles = model.count(), report.bonds = model.bonds.count();
  report.spacing = model.spacing, report.time_step = problem.time_step();
  report.stiffness_number = problem.stiffness_number();
  report.step = problem.start().step;
  report.residual_at_start = problem.first_residual();
  report.reference = problem.reference();
  options.say(
      fmt::format("reference: residual {:.1e} of the start's after {} iterations, {:.1f} s; the second "
                  "start ends {:.1e} spacings away",
                  report.reference.residual, report.reference.iterations, report.reference.seconds,
                  report.reference.agree_max));
  std::vector<std::unique_ptr<Device>> devices;
  devices.reserve(places.size());
  for (const Place& place : places) devices.push_back(open_device(place.request));
  std::map<std::string, std::vector<std::string>> refused; // by reason
  std::size_t left = variants.size() * places.size();
  for (const Variant& variant : variants)
    for (std::size_t p = 0; p < places.size(); ++p, --left) {
      ConvergeSeries name;
      name.method = variant.method, name.preconditioner = variant.preconditioner;
      name.backend = places[p].backend, name.precision = places[p].precision;
      const std::string label = name.variant() + " on " + name.place();
      const double share = (options.total_seconds - elapsed()) / static_cast<double>(left);
      try {
        report.series.push_back(race(variant, places[p], *devices[p], scene, model, problem,
                                     std::max(0.5, std::min(options.seconds, share))));
        const ConvergeSeries& series = report.series.back();
        options.say(fmt::format("{}: {} iterations, {:.4g} ms, {:.1e} spacings; ended at {}", label,
                                series.points.back().iteration, series.points.back().ms,
                                series.points.back().position_rms, series.end));
      } catch (const Error& error) {
        if (error.code() != ExitCode::usage && error.code() != ExitCode::too_large) throw;
        refused[error.what()].push_back(label);
        options.say("left out: " + label + ": " + error.what());
      }
    }
  for (const auto& [why, labels] : refused)
    report.left_out.push_back(fmt::format("{}: {}", fmt::join(labels, ", "), why));
  report.seconds = elapsed();
  return report;
}

} // namespace pliant
