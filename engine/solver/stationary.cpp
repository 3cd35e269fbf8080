// Runs the stationary methods' kernels.
#include "engine/solver/stationary.h"

#include "engine/solver/contact.h"
#include "engine/solver/state.h"
#include "kernels/chebyshev_step.h"
#include "kernels/guard_apply.h"
#include "kernels/residual_control.h"

#include <algorithm>
#include <cmath>

namespace pliant {

double chebyshev_gap(double stiffness_number, bool contacts, double tolerance, unsigned budget) {
  const double eta = stiffness_number * (contacts ? 2 : 1);
  const double reduction = std::log(2 / std::min(std::max(tolerance, 1e-3), 0.2));
  const double resolved = 0.5 * std::pow(reduction / std::max(budget, 1u), 2);
  return std::min(std::max({1 / (1 + eta), resolved, 1e-7}), 1.0);
}

void Stationary::begin(const SolveBounds& bounds) {
  bounds_ = bounds;
  const SolverSettings& settings = context_.scene.solver;
  one_minus_rho_ =
      chebyshev_gap(bounds.stiffness_number, context_.contacts != nullptr, settings.tolerance, bounds.cap);
  if (settings.spectral_radius) one_minus_rho_ = std::max(1 - *settings.spectral_radius, 1e-7);
  SimulationState& s = context_.state;
  context_.device.copy(s.displacement, s.earlier_iterate);
}

void Stationary::apply(unsigned k, bool checked, bool restart) {
  Device& device = context_.device;
  SimulationState& s = context_.state;
  const auto n = static_cast<std::uint32_t>(context_.plan.particles);
  const SolverSettings& settings = context_.scene.solver;
  const std::string& method = context_.plan.method.name;
  const bool position = method == "position", accelerate = method == "chebyshev";
  device.enter("solver");
  device.run(
      kernels::chebyshev_step::Args{.threads = n,
                                    .checked = checked,
                                    .position = position,
                                    .contacts = context_.contacts != nullptr,
                                    .iteration = k,
                                    .inertia_target = s.inertia_target,
                                    .force = s.force,
                                    .displacement = s.displacement,
                                    .earlier_iterate = s.earlier_iterate,
                                    .solver = s.solver,
                                    .residual_partial = s.residual_partial,
                                    .touched = context_.contacts ? context_.contacts->touched() : nullptr});
  swap(s.displacement, s.earlier_iterate);
  if (!checked) return;
  device.run(kernels::residual_control::Args{
      .threads = kernels::residual_control::group_size,
      .iteration = k,
      .partial_count = static_cast<std::uint32_t>(s.residual_partial.count()),
      .restart = restart || k == 0 || position, // the average lowers no residual: its last iterate counts
      .delay = std::min(settings.delay, bounds_.cap / 2),
      .accelerate = accelerate,
      .one_minus_rho = one_minus_rho_,
      .gamma = accelerate ? settings.under_relaxation : 1.0,
      .tolerance = settings.fixed_iterations ? 0 : settings.tolerance,
      .floor_residual = settings.fixed_iterations ? 0 : bounds_.floor,
      .rounding = settings.fixed_iterations ? 0 : bounds_.rounding,
      .second_guess = !position,
      .residual_partial = s.residual_partial,
      .solver = s.solver});
  device.run(kernels::guard_apply::Args{.threads = n,
                                        .solver = s.solver,
                                        .displacement = s.displacement,
                                        .earlier_iterate = s.earlier_iterate,
                                        .best_iterate = s.best_iterate,
                                        .inertia_target = s.inertia_target});
}

} // namespace pliant
