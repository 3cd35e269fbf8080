// Runs the line search's kernels.
#include "engine/solver/line_search.h"

#include "engine/solver/state.h"
#include "kernels/line_apply.h"
#include "kernels/line_control.h"
#include "kernels/line_restart.h"
#include "kernels/residual.h"

#include <algorithm>

namespace pliant {

LineSearch::LineSearch(const SolveContext& context) : context_(context) {
  if (context.plan.method.preconditioner != "multilevel") return;
  // Coarse levels carry the volume term, the particles' own diagonal needs a seventh of it.
  for (const LawConstants& constants : context.model.constants)
    relief_ = std::min(relief_, constants.isochoric * (1 + 0.15 * std::max(constants.coupling, 0.0)) /
                                    constants.bound);
}

void LineSearch::restart() {
  SimulationState& s = context_.state;
  context_.device.run(kernels::line_restart::Args{.threads = 1, .solver = s.solver});
  context_.device.copy(s.best_iterate, s.displacement);
}

void LineSearch::judge(unsigned k, bool restart) {
  Device& device = context_.device;
  SimulationState& s = context_.state;
  const SolverSettings& settings = context_.scene.solver;
  device.enter("solver");
  device.run(kernels::residual::Args{.threads = static_cast<std::uint32_t>(context_.plan.particles),
                                     .potential = context_.plan.method.potential,
                                     .relief = relief_,
                                     .inertia_target = s.inertia_target,
                                     .force = s.force,
                                     .displacement = s.displacement,
                                     .best_iterate = s.best_iterate,
                                     .energy = s.energy,
                                     .solver = s.solver,
                                     .residual = s.residual,
                                     .solve_partial = s.solve_partial});
  device.run(kernels::line_control::Args{
      .threads = kernels::line_control::group_size,
      .potential = context_.plan.method.potential,
      .iteration = k,
      .partial_count = static_cast<std::uint32_t>(s.solve_partial.count() / 2),
      .cap = bounds_.cap,
      .restart = restart,
      .tolerance =
          settings.fixed_iterations || context_.plan.method.energy_tolerance > 0 ? 0 : settings.tolerance,
      .floor_residual = settings.fixed_iterations ? 0 : bounds_.floor,
      .rounding = settings.fixed_iterations ? 0 : bounds_.rounding,
      // A sum of n terms of one sign, by groups: a few tens of roundings.
      .noise = device.info().precision == Precision::double_precision ? 1e-14 : 3e-6,
      .solve_partial = s.solve_partial,
      .solver = s.solver});
}

void LineSearch::apply() {
  SimulationState& s = context_.state;
  context_.device.run(
      kernels::line_apply::Args{.threads = static_cast<std::uint32_t>(context_.plan.particles),
                                .solver = s.solver,
                                .displacement = s.displacement,
                                .best_iterate = s.best_iterate,
                                .inertia_target = s.inertia_target});
}

} // namespace pliant
