// Runs Newton's kernels.
#include "engine/solver/newton.h"

#include "engine/solver/contact.h"
#include "engine/solver/elasticity.h"
#include "engine/solver/state.h"
#include "kernels/conjugate_control.h"
#include "kernels/conjugate_direction.h"
#include "kernels/conjugate_update.h"
#include "kernels/newton_product.h"

namespace pliant {

Newton::Newton(const SolveContext& context)
    : GlobalStep(context), line_(context), preconditioner_(make_preconditioner(context)) {}

void Newton::begin(const SolveBounds& bounds) {
  bounds_ = bounds;
  line_.begin(bounds);
  preconditioner_->begin(bounds);
}

void Newton::apply(unsigned k, bool, bool restart) {
  Device& device = context_.device;
  SimulationState& s = context_.state;
  const auto n = static_cast<std::uint32_t>(context_.plan.particles);
  line_.judge(k, restart);
  line_.apply();
  context_.elasticity.tangent(s.best_iterate);
  preconditioner_->refresh();
  preconditioner_->apply();
  control(false);
  device.run(kernels::conjugate_direction::Args{.threads = n,
                                                .solver = s.solver,
                                                .preconditioned = s.preconditioned,
                                                .best_iterate = s.best_iterate,
                                                .direction = s.direction,
                                                .descent = s.descent,
                                                .displacement = s.displacement});
  context_.elasticity.product(s.direction);
  if (context_.contacts) context_.contacts->add_product(contact_state(s), s.best_iterate, s.direction);
  device.enter("solver");
  device.run(
      kernels::newton_product::Args{.threads = n,
                                    .obstacles = context_.plan.boundaries,
                                    .inertia_target = s.inertia_target,
                                    .direction = s.direction,
                                    .contact_block = context_.contacts ? context_.contacts->block() : nullptr,
                                    .solver = s.solver,
                                    .force = s.force,
                                    .solve_partial = s.solve_partial});
  control(true);
  device.run(kernels::conjugate_update::Args{.threads = n,
                                             .solver = s.solver,
                                             .direction = s.direction,
                                             .force = s.force,
                                             .best_iterate = s.best_iterate,
                                             .descent = s.descent,
                                             .residual = s.residual,
                                             .displacement = s.displacement});
}

void Newton::control(bool after) {
  SimulationState& s = context_.state;
  context_.device.enter("solver");
  context_.device.run(kernels::conjugate_control::Args{
      .threads = kernels::conjugate_control::group_size,
      .after = after,
      .partial_count = static_cast<std::uint32_t>(s.solve_partial.count() / 2),
      .potential = context_.plan.method.potential,
      .cap = bounds_.cap,
      .energy_tolerance = context_.scene.solver.fixed_iterations ? 0 : context_.plan.method.energy_tolerance,
      .solve_partial = s.solve_partial,
      .solver = s.solver});
}

} // namespace pliant
