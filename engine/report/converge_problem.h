// One step of a scene as a problem with a known answer: the state it starts from, the converged end, and the
// error of any other end.
#pragma once

#include "engine/report/converge.h"
#include "engine/solver/simulation.h"

#include <memory>

namespace pliant {

/// Processor of the openmp backend with this many threads, "" where there is none.
DeviceRequest double_precision(unsigned threads);

/// rms and largest distance, in spacings.
struct Distance {
  double rms = 0, max = 0;
};
Distance distance_between(const std::vector<Vector3>& a, const std::vector<Vector3>& b, double spacing);

/// The scene with the reference's solver: newton, or where the law has no derivative chebyshev, that ends
/// where the precision ends.
Scene reference_scene(const Scene& scene, const Model& model);

class StepProblem {
public:
  /// Runs the scene to the state, and solves the step twice.
  StepProblem(const Scene& scene, const Model& model, const ConvergeOptions& options);

  const Snapshot& start() const { return start_; }
  const ConvergeReference& reference() const { return reference_; }
  double first_residual() const { return first_.residual; } ///< sqrt(N m)
  double stiffness_number() const { return judge_->stiffness_number(); }
  double time_step() const { return judge_->time_step(); }
  const DeviceInfo& device() const { return device_->info(); }
  /// Errors of an end of the step; iteration and ms are left to the caller.
  ConvergePoint errors(std::vector<Vector3> positions);

private:
  void find_state(const Scene& scene, const ConvergeOptions& options);
  void solve(const ConvergeOptions& options);
  std::vector<Vector3> converged(const std::vector<Vector3>* guess, unsigned& iterations);

  const Model& model_;
  Scene judged_;
  std::unique_ptr<Device> device_;
  std::unique_ptr<Simulation> judge_, solver_;
  bool potential_ = false;
  Snapshot start_;
  Simulation::Evaluation first_, last_;
  std::vector<Vector3> answer_;
  ConvergeReference reference_;
};

} // namespace pliant
