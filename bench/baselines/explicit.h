// Explicit integration of a force: symplectic Euler, v += h f / m, then y += h v. Stable about the rest shape
// while h < 2 / w, w the highest frequency of its vibrations.
#pragma once

#include "bench/baselines/baseline.h"

namespace pliant::bench {

class ExplicitIntegration : public Baseline {
public:
  using Baseline::Baseline;
  /// Internal elastic forces at world positions, N.
  virtual Points forces(const Points& y) = 0;
  /// 2 / w by power iteration on the derivative of the forces at rest, held particles at rest.
  double stable_step() override;

protected:
  void step(double h) override;
};

} // namespace pliant::bench
