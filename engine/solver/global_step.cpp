// The choice among global steps.
#include "engine/solver/global_step.h"

#include "engine/core/error.h"
#include "engine/solver/newton.h"
#include "engine/solver/stationary.h"

namespace pliant {

std::unique_ptr<GlobalStep> make_global_step(const SolveContext& context) {
  if (context.plan.method.name == "newton") return std::make_unique<Newton>(context);
  if (context.plan.method.line_search)
    throw Error(ExitCode::usage, "solver.method \"" + context.plan.method.name + "\" is not in this build");
  return std::make_unique<Stationary>(context);
}

} // namespace pliant
