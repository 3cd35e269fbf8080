// Jacobi's iteration, plain, with Chebyshev acceleration, or in the manner of position-based dynamics.
#pragma once

#include "engine/solver/global_step.h"

namespace pliant {

/// One less the spectral radius that Chebyshev's acceleration assumes: of Jacobi's iteration, 1 - 1 / (1 +
/// eta), where a contact adds as much stiffness again; but no closer to one than `budget` iterations can
/// resolve: that would only add oscillation.
double chebyshev_gap(double stiffness_number, bool contacts, double tolerance, unsigned budget);

class Stationary : public GlobalStep {
public:
  using GlobalStep::GlobalStep;
  void begin(const SolveBounds& bounds) override;
  void apply(unsigned k, bool checked, bool restart) override;
  unsigned check_every() const override { return 8; } // more often costs more than it saves

private:
  SolveBounds bounds_;
  double one_minus_rho_ = 1;
};

} // namespace pliant
