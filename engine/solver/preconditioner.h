// What stands for the inverse of the derivative in a method with a line search: z = P^-1 r.
#pragma once

#include "engine/solver/global_step.h"

#include <memory>

namespace pliant {

/// The diagonal of the constant matrix, and the base of the others.
class Preconditioner {
public:
  explicit Preconditioner(const SolveContext& context) : context_(context) {}
  virtual ~Preconditioner() = default;
  Preconditioner(const Preconditioner&) = delete;
  Preconditioner& operator=(const Preconditioner&) = delete;

  /// Before the first iteration of a step.
  virtual void begin(const SolveBounds&) {}
  /// Where the line search has taken an iterate: follows it.
  virtual void refresh() {}
  /// `preconditioned` from `residual`, and r . z in `solve_partial`.
  virtual void apply();

protected:
  SolveContext context_;
};

std::unique_ptr<Preconditioner> make_preconditioner(const SolveContext& context);

} // namespace pliant
