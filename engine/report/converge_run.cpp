// Runs a scene with many tolerances and steps, and compares the ends.
#include "engine/report/converge_run.h"

#include "engine/core/error.h"
#include "engine/report/converge_problem.h"
#include "engine/solver/stiffness.h"

#include <Eigen/Dense>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <numeric>

namespace pliant {

namespace {

using Clock = std::chrono::steady_clock;

constexpr double tolerances[] = {1e-1, 1e-2, 1e-3, 1e-4, 1e-5};
constexpr unsigned budgets[] = {1, 2, 5, 10, 20, 50, 100, 200, 500};
constexpr double tight = 1e-8;       ///< relative residual of the references
constexpr double repeat_below = 300; ///< ms: shorter runs are repeated
constexpr unsigned repeats = 5;
constexpr double near_enough = 1.1;                         ///< times the least error that a step allows
constexpr double reference_share = 0.3, space_share = 0.35; ///< of the time

struct End {
  std::vector<Vector3> position; ///< m
  std::vector<double> ms;        ///< of each frame
  std::vector<double> iterations;
};

double part(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(std::lround(share * static_cast<double>(values.size() - 1)))];
}

class WorkPrecision {
public:
  WorkPrecision(const Scene& scene, const CurveOptions& options)
      : scene_(scene), options_(options), model_(assemble(scene)),
        precise_(open_device(double_precision(options.device.threads))),
        device_(open_device(options.device)) {}

  CurveReport run() {
    describe();
    choose_frames();
    references();
    budget_runs(); // the quick ones
    tolerance_runs();
    space();
    judge();
    report_.seconds = elapsed();
    return std::move(report_);
  }

private:
  double elapsed() const { return std::chrono::duration<double>(Clock::now() - began_).count(); }
  double left() const { return options_.total_seconds - elapsed(); }

  void describe() {
    report_.scene = scene_.name;
    report_.particles = model_.count(), report_.bonds = model_.bonds.count();
    report_.spacing = model_.spacing;
    report_.time_step = whole_step(scene_);
    report_.stiffness_number = stiffness_of(model_, report_.time_step).number;
    const DeviceInfo& info = device_->info();
    report_.device = info.name, report_.threads = info.threads;
    report_.precision = info.precision == Precision::double_precision ? "double" : "float";
    report_.method = choose_method(scene_, model_).name;
  }

  Scene with_step(double step) const {
    Scene scene = scene_;
    scene.simulation.time_step = step;
    return scene;
  }
  Scene tight_scene(double step) const {
    Scene scene = reference_scene(with_step(step), model_);
    scene.solver.tolerance = tight;
    scene.solver.energy_tolerance.reset();
    scene.solver.iterations = 20'000;
    return scene;
  }

  /// Nothing where it takes longer than `limit`, s. Throws Error(diverged).
  std::optional<End> simulate(Device& device, const Scene& scene, const Model& model, unsigned frames,
                              double limit) const {
    Simulation simulation(device, scene, model);
    const auto steps = static_cast<unsigned>(std::lround(1 / scene.output.fps / simulation.time_step()));
    End end;
    double total = 0;
    for (unsigned frame = 0; frame < frames; ++frame) {
      device.finish();
      const auto start = Clock::now();
      for (unsigned s = 0; s < steps; ++s) simulation.step();
      device.finish();
      end.ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
      total += end.ms.back() / 1000;
      for (const StepStatistics& row : simulation.take_statistics()) {
        end.iterations.push_back(row.iterations);
        if (row.not_finite > 0)
          throw Error(ExitCode::diverged,
                      fmt::format("step {}: {} particles are no longer finite", row.step, row.not_finite));
      }
      if (total > limit) return std::nullopt;
    }
    end.position = simulation.positions();
    return end;
  }

  void choose_frames() {
    const auto all = static_cast<unsigned>(std::lround(scene_.simulation.end * scene_.output.fps));
    if (options_.frames) {
      report_.frames = *options_.frames;
    } else {
      const auto frame = simulate(*precise_, tight_scene(report_.time_step / 8), model_, 1, 1e300);
      // All references together take about twice as long as the finest.
      const double each = 2 * frame->ms[0] / 1000, fit = reference_share * left() / std::max(each, 1e-6);
      report_.frames = static_cast<unsigned>(std::clamp(fit, 1.0, static_cast<double>(std::max(all, 1u))));
      if (report_.frames < all)
        options_.say(
            fmt::format("{} of {} frames fit the time; --frames asks for more", report_.frames, all));
    }
    report_.duration = report_.frames / scene_.output.fps;
  }

  void references() {
    report_.reference_step = whole_step(with_step(report_.time_step / 8));
    options_.say(
        fmt::format("reference: steps of {:.4g} s over {:.4g} s", report_.reference_step, report_.duration));
    finest_ =
        simulate(*precise_, tight_scene(report_.reference_step), model_, report_.frames, 1e300)->position;
    for (const double factor : {2.0, 1.0, 0.5, 0.25}) {
      const double step = whole_step(with_step(factor * report_.time_step));
      const auto same = [step](const CurveReport::Step& s) {
        return std::abs(s.time_step - step) < 1e-9 * step;
      };
      if (std::any_of(report_.steps.begin(), report_.steps.end(), same)) continue;
      options_.say(fmt::format("tight run with steps of {:.4g} s", step));
      try {
        End end = *simulate(*precise_, tight_scene(step), model_, report_.frames, 1e300);
        report_.steps.push_back({step, apart(end.position, finest_).rms, part(end.ms, 0.5)});
        tight_.push_back(std::move(end.position));
      } catch (const Error& error) {
        if (error.code() != ExitCode::diverged || step <= report_.time_step) throw;
        report_.left_out.push_back(fmt::format("steps of {:.4g} s: {}", step, error.what()));
      }
    }
  }

  Distance apart(const std::vector<Vector3>& a, const std::vector<Vector3>& b) const {
    return distance_between(a, b, model_.spacing);
  }

  /// False where the time was up.
  bool timed(const Scene& scene, std::size_t step, CurvePoint point, double limit) {
    const std::string name = point.budget ? fmt::format("{} iterations", point.budget)
                                          : fmt::format("tolerance {:.0e}", point.tolerance);
    const std::string label = fmt::format("steps of {:.4g} s, {}", point.time_step, name);
    std::optional<End> end;
    try {
      end = simulate(*device_, scene, model_, report_.frames, limit);
    } catch (const Error& error) {
      if (error.code() != ExitCode::diverged) throw;
      report_.left_out.push_back(label + ": " + error.what());
      return true;
    }
    if (!end) {
      report_.left_out.push_back(fmt::format("{}: more than {:.3g} s", label, limit));
      return false;
    }
    // A short run says little about its time: the same again, for the clock alone.
    const auto spent = [&] { return std::accumulate(end->ms.begin(), end->ms.end(), 0.0); };
    for (unsigned again = 1; again < repeats && spent() < repeat_below; ++again) {
      const std::optional<End> more = simulate(*device_, scene, model_, report_.frames, limit);
      if (more) end->ms.insert(end->ms.end(), more->ms.begin(), more->ms.end());
    }
    point.ms = part(end->ms, 0.5), point.ms_worst = part(end->ms, 0.95);
    point.iterations = part(end->iterations, 0.5);
    point.solver_error = apart(end->position, tight_[step]).rms;
    const Distance total = apart(end->position, finest_);
    point.total_error = total.rms, point.total_max = total.max;
    options_.say(fmt::format("{}: {:.4g} ms a frame, {:.2e} spacings", label, point.ms, point.total_error));
    report_.points.push_back(point);
    return true;
  }

  void budget_runs() {
    for (std::size_t s = 0; s < report_.steps.size(); ++s) {
      if (std::abs(report_.steps[s].time_step - report_.time_step) > 1e-9 * report_.time_step) continue;
      for (const unsigned budget : budgets) {
        Scene scene = with_step(report_.time_step);
        scene.solver.iterations = budget;
        scene.solver.fixed_iterations = true;
        if (!timed(scene, s, {.time_step = report_.time_step, .budget = budget}, left() / 8)) return;
      }
    }
  }

  void tolerance_runs() {
    for (std::size_t s = 0; s < report_.steps.size(); ++s)
      for (const double tolerance : tolerances) {
        Scene scene = with_step(report_.steps[s].time_step);
        scene.solver.tolerance = tolerance;
        scene.solver.energy_tolerance.reset();
        if (!timed(scene, s, {.time_step = report_.steps[s].time_step, .tolerance = tolerance}, left() / 6))
          break;
      }
  }

  void space() {
    const auto own =
        std::find_if(report_.steps.begin(), report_.steps.end(), [&](const CurveReport::Step& step) {
          return std::abs(step.time_step - report_.time_step) < 1e-9 * report_.time_step;
        });
    // Eight times the particles, and more iterations.
    const double expected = 16 * own->ms / 1000 * report_.frames;
    if (expected > space_share * options_.total_seconds || expected > left()) {
      report_.space_note = fmt::format("left out: half the spacing would take about {:.0f} s", expected);
      return;
    }
    options_.say(fmt::format("half the spacing: about {:.0f} s", expected));
    Scene fine_scene = tight_scene(report_.time_step);
    fine_scene.simulation.spacing /= 2;
    try {
      const Model fine = assemble(fine_scene);
      const auto end = simulate(*precise_, fine_scene, fine, report_.frames, left());
      if (!end) {
        report_.space_note = "left out: half the spacing took too long";
        return;
      }
      compare(fine, end->position, tight_[static_cast<std::size_t>(own - report_.steps.begin())]);
    } catch (const Error& error) {
      report_.space_note = std::string("left out: with half the spacing, ") + error.what();
    }
  }

  /// Displacements of the fine run, fitted linearly to the eight particles around each coarse one.
  void compare(const Model& fine, const std::vector<Vector3>& fine_end,
               const std::vector<Vector3>& coarse_end) {
    double sum = 0;
    std::size_t probes = 0;
    const double reach = 0.75 * model_.spacing;
    for (std::size_t b = 0; b < model_.bodies.size(); ++b) {
      const BodyModel &coarse_body = model_.bodies[b], &fine_body = fine.bodies[b];
      for (std::uint32_t i = coarse_body.first; i < coarse_body.first + coarse_body.count; ++i) {
        std::vector<std::uint32_t> around;
        for (std::uint32_t k = fine_body.first; k < fine_body.first + fine_body.count; ++k)
          if ((fine.position[k] - model_.position[i]).cwiseAbs().maxCoeff() < reach) around.push_back(k);
        if (around.size() < 8) continue;
        Eigen::MatrixXd places(around.size(), 4);
        Eigen::MatrixXd moves(around.size(), 3);
        for (std::size_t r = 0; r < around.size(); ++r) {
          const auto row = static_cast<Eigen::Index>(r);
          places(row, 0) = 1;
          places.block<1, 3>(row, 1) =
              (fine.position[around[r]] - model_.position[i]).transpose() / model_.spacing;
          moves.row(row) = (fine_end[around[r]] - fine.position[around[r]]).transpose();
        }
        const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> fit(places);
        if (fit.rank() < 4) continue;
        const Vector3 moved = fit.solve(moves).row(0).transpose();
        sum += (moved - (coarse_end[i] - model_.position[i])).squaredNorm();
        ++probes;
      }
    }
    if (probes == 0) {
      report_.space_note = "left out: no place has eight particles of both spacings around it";
      return;
    }
    report_.space_error = std::sqrt(sum / static_cast<double>(probes)) / model_.spacing;
    report_.space_note =
        fmt::format("against {} particles at {} of {} places", fine.count(), probes, model_.count());
  }

  void judge() {
    const double floor = std::max(report_.time_error(), report_.space_error.value_or(0));
    for (const CurvePoint& point : report_.points) // budgets rise
      if (point.budget > 0) {
        if (point.solver_error >= floor)
          report_.enough.reset();
        else if (!report_.enough)
          report_.enough = point.budget;
      }
    const double limit = near_enough * floor;
    std::optional<std::size_t> least;
    for (std::size_t p = 0; p < report_.points.size(); ++p) {
      const CurvePoint& point = report_.points[p];
      if (point.budget > 0) continue;
      if (!least || point.total_error < report_.points[*least].total_error) least = p;
      if (point.total_error <= limit && (!report_.pick || point.ms < report_.points[*report_.pick].ms))
        report_.pick = p;
    }
    if (!report_.pick) report_.pick = least;
  }

  const Scene& scene_;
  const CurveOptions& options_;
  Model model_;
  std::unique_ptr<Device> precise_, device_;
  std::vector<Vector3> finest_;
  std::vector<std::vector<Vector3>> tight_; ///< ends, one a step
  CurveReport report_;
  Clock::time_point began_ = Clock::now();
};

} // namespace

double CurveReport::time_error() const {
  for (const Step& step : steps)
    if (std::abs(step.time_step - time_step) < 1e-9 * time_step) return step.time_error;
  return 0;
}

CurveReport work_precision(const Scene& scene, const CurveOptions& options) {
  if (scene.bodies.empty()) throw Error(ExitCode::usage, "the scene has no particles: give it a [[body]]");
  return WorkPrecision(scene, options).run();
}

} // namespace pliant
