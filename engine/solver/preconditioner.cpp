// The diagonal preconditioner, and the choice among all.
#include "engine/solver/preconditioner.h"

#include "engine/solver/direct.h"
#include "engine/solver/multilevel.h"
#include "engine/solver/state.h"
#include "kernels/precondition.h"

namespace pliant {

void Preconditioner::apply() {
  SimulationState& s = context_.state;
  context_.device.enter("solver");
  context_.device.run(
      kernels::precondition::Args{.threads = static_cast<std::uint32_t>(context_.plan.particles),
                                  .residual = s.residual,
                                  .solver = s.solver,
                                  .preconditioned = s.preconditioned,
                                  .solve_partial = s.solve_partial});
}

std::unique_ptr<Preconditioner> make_preconditioner(const SolveContext& context) {
  if (context.plan.method.preconditioner == "multilevel") return std::make_unique<Multilevel>(context);
  if (context.plan.method.preconditioner == "direct") return std::make_unique<Direct>(context);
  return std::make_unique<Preconditioner>(context);
}

} // namespace pliant
