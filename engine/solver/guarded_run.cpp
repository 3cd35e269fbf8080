// A run that catches divergence.
#include "engine/solver/guarded_run.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace pliant {

namespace {

constexpr unsigned most_parts = 8; ///< a step that diverges in eight parts is not saved by sixteen
constexpr double generosity = 10;  ///< of the speed limit: no physical scene comes near it

double speed_of(const Motion& motion, double reach) {
  return motion.velocity.norm() + std::abs(motion.rate) * reach;
}

} // namespace

GuardedRun::GuardedRun(Simulation& simulation, const Scene& scene, const Model& model,
                       unsigned steps_per_frame)
    : simulation_(simulation), model_(model), steps_per_frame_(steps_per_frame) {
  if (!simulation.plan().divergence)
    throw Error(ExitCode::internal, "a guarded run needs divergence in the simulation's plan");
  Vector3 low = model.position.front(), high = low;
  double fastest = 0, pace = 0;
  const std::vector<double> stiffness = diagonal_stiffness(model);
  for (std::size_t i = 0; i < model.count(); ++i) {
    low = low.cwiseMin(model.position[i]);
    high = high.cwiseMax(model.position[i]);
    fastest = std::max(fastest, model.velocity[i].norm());
    pace = std::max(pace, stiffness[i] / model.mass[i]);
  }
  const Vector3 middle = (low + high) / 2;
  const double size = (high - low).norm() + model.spacing;
  const auto reach = [&](const Motion& motion, double extent) {
    return (motion.about - middle).norm() + size + extent;
  };
  double driven = 0;
  for (const Motion& motion : model.motions) driven = std::max(driven, speed_of(motion, reach(motion, 0)));
  for (const Boundary& boundary : scene.boundaries) {
    const Shape& shape = boundary.shape;
    const double extent = (shape.at - middle).norm() + shape.size.norm() + shape.radius + shape.height;
    driven = std::max(driven, speed_of(boundary.motion, reach(boundary.motion, extent)));
  }
  double load = 0;
  for (const Load& one : model.loads) load = std::max(load, one.force.norm() / model.mass[one.particle]);
  limit_ = generosity * (fastest + driven + size * std::min(std::sqrt(pace), 1 / simulation.time_step()));
  if (scene.flows()) limit_ += generosity * model.spacing / simulation.time_step(); // particles that part
  limit_growth_ = generosity * (scene.simulation.gravity.norm() + load);
  limit_ += limit_growth_ * simulation.time_step();
  simulation_.keep();
}

std::uint64_t GuardedRun::end_of_stretch(std::uint64_t last) const {
  const std::uint64_t step = simulation_.steps();
  std::uint64_t end = (step / stretch_steps + 1) * stretch_steps;
  if (steps_per_frame_ > 0) end = std::min(end, (step / steps_per_frame_ + 1) * steps_per_frame_);
  return std::min(end, last);
}

bool GuardedRun::good(const StepStatistics& row) const {
  return row.not_finite == 0 && row.neighbours_dropped == 0 && row.largest_speed <= speed_limit(row.time);
}

std::string GuardedRun::cause(const StepStatistics& row) const {
  if (row.not_finite > 0)
    return fmt::format("{} particle{} no longer finite", row.not_finite,
                       row.not_finite == 1 ? " is" : "s are");
  if (row.neighbours_dropped > 0)
    return fmt::format("{} lists of neighbours lack room for {}: particles crowd; [fluid] neighbours gives "
                       "lists more room",
                       row.lists_full, row.neighbours_dropped);
  return fmt::format("a speed of {:.3g} m/s, where nothing in the scene accounts for {:.3g} m/s",
                     row.largest_speed, speed_limit(row.time));
}

std::string GuardedRun::culprit(const StepStatistics& row) {
  const std::vector<Vector3> x = simulation_.positions(), v = simulation_.velocities();
  std::size_t found = x.size();
  const auto before = [&](std::size_t a, std::size_t b) { return model_.id[a] < model_.id[b]; };
  for (std::size_t i = 0; i < x.size(); ++i) {
    const bool wrong = row.not_finite > 0 ? !x[i].allFinite() || !v[i].allFinite()
                                          : found == x.size() || v[i].norm() > v[found].norm();
    if (wrong && (row.not_finite == 0 || found == x.size() || before(i, found))) found = i;
  }
  if (found == x.size()) { // finite, but its square is not
    found = 0;
    for (std::size_t i = 1; i < x.size(); ++i)
      if (v[i].norm() > v[found].norm()) found = i;
  }
  return fmt::format("particle {} of body '{}'", model_.id[found], model_.bodies[model_.body[found]].name);
}

void GuardedRun::give_up(const StepStatistics& row) {
  const std::string where = culprit(row), why = cause(row);
  simulation_.rewind();
  throw Error(
      ExitCode::diverged,
      fmt::format("step {} (t = {:.6g} s) diverged at {}: {}, even with the step in {} parts. The last "
                  "good state is that of step {} (t = {:.6g} s). Use a smaller time step, more "
                  "iterations, or look at what acts on that particle",
                  row.step, row.time, where, why, most_parts, simulation_.steps(), simulation_.time()));
}

std::vector<StepStatistics> GuardedRun::advance(std::uint64_t last, const GuardedCalls& calls) {
  const std::uint64_t start = simulation_.steps(), end = end_of_stretch(last);
  for (unsigned parts = 1;; parts *= 2) {
    if (calls.begin) calls.begin(parts);
    full_.reset();
    std::vector<StepStatistics> rows;
    while (simulation_.steps() < end) {
      if (calls.before_step && !calls.before_step()) {
        simulation_.rewind();
        return {};
      }
      try {
        if (parts == 1)
          simulation_.step();
        else
          simulation_.step_divided(parts);
      } catch (const Error& error) { // before the step: the scene is full
        if (error.code() != ExitCode::too_large) throw;
        full_ = error;
        break;
      }
      if (calls.after_step) calls.after_step();
      if (parts < most_parts) continue;
      // The last try is watched closely: its first bad step is the one to be named.
      for (const StepStatistics& row : simulation_.take_statistics()) rows.push_back(row);
      if (!good(rows.back())) give_up(rows.back());
    }
    for (const StepStatistics& row : simulation_.take_statistics()) rows.push_back(row);
    const auto bad =
        std::find_if(rows.begin(), rows.end(), [this](const StepStatistics& row) { return !good(row); });
    if (bad == rows.end()) {
      if (parts > 1) divided_steps_ += simulation_.steps() - start;
      simulation_.keep();
      return rows;
    }
    const std::string why = cause(*bad);
    simulation_.rewind();
    ++retries_;
    if (calls.say)
      calls.say(fmt::format("step {} diverged ({}): back to step {}, each step in {} parts up to step {}",
                            bad->step, why, start, 2 * parts, end));
  }
}

} // namespace pliant
