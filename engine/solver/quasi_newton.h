// Methods with a constant matrix: its inverse applied to the residual, alone (direct: the local-global step
// of projective dynamics, P = A) or corrected by the last five steps (L-BFGS; Liu, Bouaziz and Kavan 2017).
#pragma once

#include "engine/solver/global_step.h"
#include "engine/solver/line_search.h"
#include "engine/solver/preconditioner.h"

namespace pliant {

class QuasiNewton : public GlobalStep {
public:
  explicit QuasiNewton(const SolveContext& context);
  void begin(const SolveBounds& bounds) override;
  void restart() override { line_.restart(); }
  void apply(unsigned k, bool checked, bool restart) override;
  unsigned check_every() const override { return 4; }

private:
  LineSearch line_;
  std::unique_ptr<Preconditioner> preconditioner_;
  bool remembers_ = false, follows_ = false; ///< earlier steps; the preconditioner, the material
  double largest_scale_ = 2, first_length_ = 1;
};

} // namespace pliant
