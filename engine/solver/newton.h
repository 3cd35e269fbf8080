// Newton's method with conjugate gradients, without a matrix (Dembo and Steihaug 1983; forcing after
// Eisenstat and Walker 1996): each iteration is one evaluation, or one product with the derivative.
#pragma once

#include "engine/solver/global_step.h"
#include "engine/solver/line_search.h"
#include "engine/solver/preconditioner.h"

namespace pliant {

class Newton : public GlobalStep {
public:
  explicit Newton(const SolveContext& context);
  void begin(const SolveBounds& bounds) override;
  void restart() override { line_.restart(); }
  void apply(unsigned k, bool checked, bool restart) override;
  unsigned check_every() const override { return 4; }

private:
  void control(bool after);

  LineSearch line_;
  std::unique_ptr<Preconditioner> preconditioner_;
  SolveBounds bounds_;
};

} // namespace pliant
