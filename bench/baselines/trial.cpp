// Runs a baseline and measures it.
#include "bench/baselines/trial.h"

#include "engine/core/error.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <fmt/format.h>
#include <fstream>

namespace pliant::bench {
namespace {

/// Determinant of the best affine map of a particle's neighbourhood, times a positive number.
double orientation(const Model& model, const Points& y, std::uint32_t i) {
  Matrix3 yx = Matrix3::Zero();
  for (std::uint32_t b = model.bonds.begin[i]; b < model.bonds.begin[i + 1]; ++b) {
    const std::uint32_t j = model.bonds.neighbour[b];
    yx += (y[j] - y[i]) * (model.reference[j] - model.reference[i]).transpose();
  }
  return yx.determinant();
}

/// Sum of squared distances of a body to its rest shape (Kabsch 1976).
double squared_distance(const Model& model, const BodyModel& body, const Points& y) {
  Vector3 c = Vector3::Zero(), c0 = c;
  for (std::uint32_t i = body.first; i < body.first + body.count; ++i) c += y[i], c0 += model.reference[i];
  c /= body.count, c0 /= body.count;
  Matrix3 a = Matrix3::Zero();
  for (std::uint32_t i = body.first; i < body.first + body.count; ++i)
    a += (y[i] - c) * (model.reference[i] - c0).transpose();
  const Matrix3 rotation = signed_rotation(a);
  double sum = 0;
  for (std::uint32_t i = body.first; i < body.first + body.count; ++i)
    sum += (y[i] - c - rotation * (model.reference[i] - c0)).squaredNorm();
  return sum;
}

bool lost(const Points& y, const Vector3& low, const Vector3& high) {
  const double reach = 10 * (high - low).norm();
  const Vector3 middle = (low + high) / 2;
  return std::any_of(y.begin(), y.end(), [&](const Vector3& p) { return !((p - middle).norm() < reach); });
}

/// s, of this thread: a crowded machine does not show in it.
double cpu_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

} // namespace

Sample measure(const Model& model, const Baseline& baseline) {
  const Points& y = baseline.positions();
  Sample sample;
  sample.time = baseline.time();
  double end = -1e300, tips = 0, mass = 0;
  for (const Vector3& p : model.position) end = std::max(end, p.x());
  for (std::uint32_t i = 0; i < y.size(); ++i) {
    if (model.position[i].x() > end - model.spacing / 2)
      sample.tip_depth += model.position[i].y() - y[i].y(), ++tips;
    sample.upright += orientation(model, y, i) > 0;
    mass += model.mass[i];
    sample.speed += model.mass[i] * baseline.velocities()[i].squaredNorm();
  }
  const auto count = static_cast<double>(y.size());
  sample.tip_depth /= tips;
  sample.upright /= count;
  sample.speed = std::sqrt(sample.speed / mass);
  double squared = 0;
  for (const BodyModel& body : model.bodies) squared += squared_distance(model, body, y);
  sample.distance = std::sqrt(squared / count) / model.spacing;
  return sample;
}

Trial run_trial(const std::string& method, const Scene& scene, const Model& model,
                const TrialSettings& settings) {
  const auto baseline = make_baseline(method, scene, model);
  baseline->set_damping(settings.damping);
  Trial trial;
  trial.method = method;
  trial.stable_step = baseline->stable_step();
  const double wanted = settings.time_step > 0
                            ? settings.time_step
                            : std::min(scene.simulation.time_step, safe_share * trial.stable_step);
  const auto steps = static_cast<long>(std::ceil(settings.seconds / wanted - 1e-9));
  // A step that was asked for is taken as it is.
  const double h = settings.time_step > 0 ? wanted : settings.seconds / static_cast<double>(steps);
  trial.time_step = h;
  const long every = std::max(std::lround(settings.every / h), 1L);
  Vector3 low = model.position.at(0), high = low;
  for (const Vector3& p : model.position) low = low.cwiseMin(p), high = high.cwiseMax(p);
  trial.samples.push_back(measure(model, *baseline));
  const double start = cpu_time();
  for (long k = 1; k <= steps && !trial.diverged; ++k) {
    baseline->advance(h);
    trial.diverged = lost(baseline->positions(), low, high);
    if (trial.diverged)
      trial.diverged_at = baseline->time();
    else if (k % every == 0 || k == steps)
      trial.samples.push_back(measure(model, *baseline));
  }
  trial.cpu_seconds = cpu_time() - start;
  return trial;
}

void write_csv(const std::vector<Trial>& trials, const std::filesystem::path& file) {
  std::ofstream out(file);
  out << "method,time_step,time,tip_depth,upright,distance,speed\n";
  for (const Trial& trial : trials)
    for (const Sample& s : trial.samples)
      out << fmt::format("{},{:g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}\n", trial.method, trial.time_step,
                         s.time, s.tip_depth, s.upright, s.distance, s.speed);
  if (!out.flush()) throw Error(ExitCode::input_output, file.string() + ": could not be written");
}

} // namespace pliant::bench
