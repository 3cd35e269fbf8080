// The step length (Eq. 13 of He, Wang and Wu 2017): Armijo's rule where there is a potential, the slope that
// is left along the step where there is none. Kernels decide; see kernels/line_control.decl.
#pragma once

#include "engine/solver/global_step.h"

namespace pliant {

class LineSearch {
public:
  explicit LineSearch(const SolveContext& context);
  void begin(const SolveBounds& bounds) { bounds_ = bounds; }
  /// Gives up what is being computed, so that the next iteration evaluates the best iterate.
  void restart();
  /// The residual at `displacement`, and what becomes of the step that led there.
  void judge(unsigned k, bool restart);
  /// Carries it out.
  void apply();

private:
  SolveContext context_;
  SolveBounds bounds_;
  double relief_ = 1; ///< see kernels/residual.decl
};

} // namespace pliant
