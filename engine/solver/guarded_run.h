// A run that catches divergence: it advances in stretches, looks at what each step reported when a stretch is
// done, and does not go on, or let anything be written, from a state that is not good.
//
//   good state --- stretch, step by step ---> rows good: this is the next good state
//       ^                                     a row bad: back, the same stretch with each step in 2, 4, 8
//       parts
//       +---------------------------------------------------------------+        (after that:
//       Error(diverged))
//
// Stretches end at fixed steps: whole frames and multiples of `stretch_steps`. So what is retried depends on
// the step numbers alone, never on when a row arrived, and a run resumed from a good state repeats it.
#pragma once

#include "engine/core/error.h"
#include "engine/solver/simulation.h"

#include <functional>
#include <optional>

namespace pliant {

/// More looks seldomer and repeats more steps after a divergence.
inline constexpr std::uint64_t stretch_steps = 8;

/// What a caller may watch; each may be empty.
struct GuardedCalls {
  std::function<void(unsigned parts)> begin; ///< a stretch, or its retry, each step in so many parts
  std::function<bool()> before_step;         ///< false: stop here
  std::function<void()> after_step;
  std::function<void(const std::string&)> say; ///< a line about a retry
};

class GuardedRun {
public:
  /// `simulation` has divergence in its plan, and is in a good state. `steps_per_frame`: 0 without frames.
  GuardedRun(Simulation& simulation, const Scene& scene, const Model& model, unsigned steps_per_frame);

  /// Advances by one stretch, not beyond step `last`, and returns its rows; each step has one. Nothing where
  /// `before_step` said stop: the simulation is then back in the last good state.
  /// Throws Error(diverged), naming step, body, particle and cause, with the simulation back in that state.
  std::vector<StepStatistics> advance(std::uint64_t last, const GuardedCalls& calls = {});

  /// Why the last stretch ended before its time, after whole steps: an emitter found the scene full.
  const std::optional<Error>& full() const { return full_; }

  std::uint64_t retries() const { return retries_; }
  std::uint64_t divided_steps() const { return divided_steps_; } ///< steps that were taken in parts
  void count_from(std::uint64_t retries, std::uint64_t divided_steps) {
    retries_ = retries;
    divided_steps_ = divided_steps;
  }
  /// m/s; nothing in the scene can drive a particle to this speed by `time`, s: ten times what falling, its
  /// loads, whatever moves in the scene, and crossing the whole scene in a step or at the pace of the
  /// stiffest particle's oscillation add up to.
  double speed_limit(double time) const { return limit_ + limit_growth_ * time; }

private:
  std::uint64_t end_of_stretch(std::uint64_t last) const;
  bool good(const StepStatistics& row) const;
  std::string cause(const StepStatistics& row) const;
  std::string culprit(const StepStatistics& row);
  [[noreturn]] void give_up(const StepStatistics& row);

  Simulation& simulation_;
  const Model& model_;
  unsigned steps_per_frame_;
  double limit_ = 0, limit_growth_ = 0; ///< m/s, m/s2
  std::optional<Error> full_;
  std::uint64_t retries_ = 0, divided_steps_ = 0;
};

} // namespace pliant
