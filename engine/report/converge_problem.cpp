// Finds the state, solves its step to the end, judges other ends.
#include "engine/report/converge_problem.h"

#include "engine/core/error.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <random>

namespace pliant {

namespace {

using Clock = std::chrono::steady_clock;

constexpr unsigned searched_steps = 60;     ///< for the hardest
constexpr double searching_seconds = 60;    ///< at most
constexpr double reference_seconds = 60;    ///< a start, at most
constexpr unsigned reference_cap = 200'000; ///< iterations

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

bool projective(const Model& model) {
  return std::any_of(model.laws.begin(), model.laws.end(),
                     [](const LawRange& range) { return range.law == Law::projective && range.count > 0; });
}

/// What a single-precision device keeps of a state, so that every device starts from the same numbers.
Snapshot rounded(const Scene& scene, const Model& model, const Snapshot& state, unsigned threads) {
  const std::unique_ptr<Device> device = open_device({"openmp", Precision::single_precision, threads});
  PlanRequest plain;
  plain.statistics = false;
  Simulation simulation(*device, scene, model, plain);
  simulation.restore(state);
  return simulation.snapshot();
}

} // namespace

DeviceRequest double_precision(unsigned threads) {
  return {"openmp", Precision::double_precision, threads};
}

Distance distance_between(const std::vector<Vector3>& a, const std::vector<Vector3>& b, double spacing) {
  double sum = 0, largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double square = (a[i] - b[i]).squaredNorm();
    sum += square;
    if (!(square <= largest)) largest = square; // keeps what is not a number
  }
  return {std::sqrt(sum / static_cast<double>(a.size())) / spacing, std::sqrt(largest) / spacing};
}

Scene reference_scene(const Scene& scene, const Model& model) {
  Scene tight = scene;
  tight.solver.method = projective(model) ? "chebyshev" : "newton";
  tight.solver.preconditioner = "auto";
  tight.solver.iterations = reference_cap;
  tight.solver.tolerance = 1e-13;
  tight.solver.energy_tolerance.reset();
  return tight;
}

StepProblem::StepProblem(const Scene& scene, const Model& model, const ConvergeOptions& options)
    : model_(model), judged_(reference_scene(scene, model)),
      device_(open_device(double_precision(options.threads))) {
  find_state(scene, options);
  judged_.solver.fixed_iterations = true; // it ends where no descent is left, not at a tolerance
  judge_ = std::make_unique<Simulation>(*device_, judged_, model_);
  solver_ = std::make_unique<Simulation>(*device_, judged_, model_);
  potential_ = judge_->plan().method.potential;
  judge_->restore(start_);
  judge_->begin_solving();
  solve(options);
}

void StepProblem::find_state(const Scene& scene, const ConvergeOptions& options) {
  Simulation simulation(*device_, scene, model_);
  const auto end = static_cast<unsigned>(std::lround(scene.simulation.end / simulation.time_step()));
  if (options.at && *options.at > end)
    throw Error(ExitCode::usage,
                fmt::format("--at {}: the scene ends after {} steps of {:.4g} s; name an earlier "
                            "step, or lengthen simulation.end",
                            *options.at, end, simulation.time_step()));
  const unsigned steps = options.at ? *options.at : std::min(searched_steps, std::max(end, 1u));
  options.say(options.at ? fmt::format("running {} steps with the scene's own solver, {}, in double", steps,
                                       simulation.plan().method.name)
                         : fmt::format("looking for the hardest of the first {} steps", steps));
  start_ = simulation.snapshot();
  double hardest = -1;
  const auto began = Clock::now();
  auto said = began;
  for (unsigned k = 0; k < steps; ++k) {
    Snapshot before;
    if (!options.at) before = simulation.snapshot();
    simulation.step();
    for (const StepStatistics& row : simulation.take_statistics()) {
      if (row.not_finite > 0)
        throw Error(
            ExitCode::diverged,
            fmt::format("step {}: {} particles are no longer finite with the scene's own solver; name an "
                        "earlier step with --at, or use a smaller time step",
                        row.step, row.not_finite));
      if (!options.at && row.first_residual > hardest) {
        hardest = row.first_residual;
        start_ = before; // not moved: a step may have several rows
      }
    }
    if (seconds_since(said) > 5) {
      said = Clock::now();
      options.say(fmt::format("{} of {} steps", k + 1, steps));
    }
    if (!options.at && seconds_since(began) > searching_seconds) {
      options.say(fmt::format("stopped looking after {} steps, {:.0f} s; --at names another step", k + 1,
                              searching_seconds));
      break;
    }
  }
  if (options.at) start_ = simulation.snapshot();
  start_ = rounded(scene, model_, start_, options.threads);
}

std::vector<Vector3> StepProblem::converged(const std::vector<Vector3>* guess, unsigned& iterations) {
  solver_->restore(start_);
  solver_->begin_solving();
  if (guess) solver_->start_from(*guess);
  const auto began = Clock::now();
  std::vector<Vector3> best = solver_->iterate_positions();
  double least = judge_->evaluate(best).residual;
  if (least == 0) return best;
  unsigned good = 0, next = 200;
  for (iterations = 1;; ++iterations) {
    const bool look = iterations == next, ended = solver_->iterate(look);
    if (!look && !ended) continue;
    next += std::max(200u, iterations / 4);
    const std::vector<Vector3> now = solver_->iterate_positions();
    const double residual = judge_->evaluate(now).residual;
    if (residual < 0.9 * least) good = iterations;
    if (residual < least) best = now, least = residual;
    // Rounding has the last word: two thirds of the time brought nothing.
    if (ended || iterations > 3 * good + 1000 || seconds_since(began) > reference_seconds) return best;
  }
}

void StepProblem::solve(const ConvergeOptions& options) {
  options.say(fmt::format(
      "reference: {}{} in double, from two starts", judge_->plan().method.name,
      judge_->plan().method.preconditioner.empty() ? "" : "+" + judge_->plan().method.preconditioner));
  const std::vector<Vector3> guess = judge_->iterate_positions();
  first_ = judge_->evaluate(guess);
  const auto began = Clock::now();
  answer_ = converged(nullptr, reference_.iterations);
  reference_.seconds = seconds_since(began);
  last_ = judge_->evaluate(answer_);
  // The positions at the start of the step, shaken by a hundredth of a spacing, so that they differ from the
  // guess also where nothing moves.
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> shake(-0.01 * model_.spacing, 0.01 * model_.spacing);
  std::vector<Vector3> other = start_.position;
  for (Vector3& x : other) x += Vector3(shake(random), shake(random), shake(random));
  reference_.second_start = "the positions before the step, shaken by 0.01 spacings";
  unsigned second = 0;
  const std::vector<Vector3> again = converged(&other, second);
  const Distance apart = distance_between(answer_, again, model_.spacing);
  reference_.agree_rms = apart.rms, reference_.agree_max = apart.max;
  const Distance away = distance_between(answer_, guess, model_.spacing);
  reference_.first_rms = away.rms, reference_.first_max = away.max;
  const Method& method = judge_->plan().method;
  reference_.method = method.name + (method.preconditioner.empty() ? "" : "+" + method.preconditioner);
  reference_.residual = first_.residual > 0 ? last_.residual / first_.residual : 0;
  const double none = std::numeric_limits<double>::quiet_NaN();
  reference_.potential = potential_ ? last_.potential : none;
  reference_.first_potential = potential_ ? first_.potential : none;
  reference_.energy_floor = potential_
                                ? 1e-14 * std::max(std::abs(first_.potential), std::abs(last_.potential)) /
                                      std::max(first_.potential - last_.potential, 1e-300)
                                : none;
}

ConvergePoint StepProblem::errors(std::vector<Vector3> positions) {
  // Held particles are where they are told to be: what a float rounds there is no error of a solver, but the
  // potential would feel it to first order.
  for (const Held& held : model_.held) positions[held.particle] = answer_[held.particle];
  const Simulation::Evaluation now = judge_->evaluate(positions);
  const Distance away = distance_between(positions, answer_, model_.spacing);
  ConvergePoint point;
  point.residual = first_.residual > 0 ? now.residual / first_.residual : 0;
  point.energy_error = potential_ ? (now.potential - last_.potential) / (first_.potential - last_.potential)
                                  : std::numeric_limits<double>::quiet_NaN();
  point.position_rms = away.rms, point.position_max = away.max;
  return point;
}

} // namespace pliant
