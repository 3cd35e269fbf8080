// Runs the quasi-Newton methods' kernels.
#include "engine/solver/quasi_newton.h"

#include "engine/solver/state.h"
#include "kernels/history_control.h"
#include "kernels/history_direction.h"
#include "kernels/history_dots.h"
#include "kernels/history_store.h"

namespace pliant {

namespace {

/// Iterations after which a preconditioner that turns with the material follows it and its contacts, and the
/// history, which belongs to the old one, is forgotten.
constexpr unsigned refresh_every = 32;

} // namespace

QuasiNewton::QuasiNewton(const SolveContext& context)
    : GlobalStep(context), line_(context), preconditioner_(make_preconditioner(context)),
      remembers_(context.plan.method.name == "lbfgs"),
      follows_(context.plan.method.preconditioner == "multilevel"),
      // A bound of the law at rest is up to five times what transverse motions meet,
      // of which coarse levels leave little.
      largest_scale_(context.plan.method.preconditioner == "direct"       ? 20
                     : context.plan.method.preconditioner == "multilevel" ? 2
                                                                          : 5),
      // The sum of coarse and fine corrections goes about three times too far.
      first_length_(context.plan.method.preconditioner == "multilevel" ? 0.3 : 1.0) {}

void QuasiNewton::begin(const SolveBounds& bounds) {
  line_.begin(bounds);
  preconditioner_->begin(bounds);
}

void QuasiNewton::apply(unsigned k, bool, bool restart) {
  Device& device = context_.device;
  SimulationState& s = context_.state;
  const auto n = static_cast<std::uint32_t>(context_.plan.particles);
  const bool anew = k == 0 || restart || (follows_ && k % refresh_every == 0);
  line_.judge(k, restart);
  if (remembers_)
    device.run(kernels::history_store::Args{.threads = n,
                                            .stride = n,
                                            .displacement = s.displacement,
                                            .best_iterate = s.best_iterate,
                                            .residual = s.residual,
                                            .solver = s.solver,
                                            .history = s.history});
  line_.apply();
  if (anew) preconditioner_->refresh();
  preconditioner_->apply();
  device.enter("solver");
  if (remembers_)
    device.run(kernels::history_dots::Args{.threads = n,
                                           .stride = n,
                                           .residual = s.residual,
                                           .preconditioned = s.preconditioned,
                                           .solver = s.solver,
                                           .history = s.history,
                                           .history_partial = s.history_partial});
  device.run(kernels::history_control::Args{
      .threads = kernels::history_control::group_size,
      .remembers = remembers_,
      .partial_count = static_cast<std::uint32_t>(s.solve_partial.count() / 2),
      .forget = anew,
      .largest_scale = largest_scale_,
      .first_length = first_length_,
      .energy_tolerance = context_.scene.solver.fixed_iterations ? 0 : context_.plan.method.energy_tolerance,
      .solve_partial = s.solve_partial,
      .history_partial = s.history_partial,
      .gram = s.gram,
      .solver = s.solver});
  device.run(kernels::history_direction::Args{.threads = n,
                                              .remembers = remembers_,
                                              .stride = n,
                                              .solver = s.solver,
                                              .preconditioned = s.preconditioned,
                                              .history = s.history,
                                              .best_iterate = s.best_iterate,
                                              .displacement = s.displacement});
}

} // namespace pliant
