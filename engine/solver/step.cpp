// One time step, as He, Wang and Wu (2017) write it in section 4: predict, then alternate a local step, which
// finds what each particle's neighbourhood would like to be, with a global step, which moves the particles
// there.
#include "engine/solver/contact.h"
#include "engine/solver/simulation.h"
#include "engine/solver/state.h"
#include "kernels/all.h"
#include "shaders/common/solver.glsl"

#include <algorithm>

namespace pliant {

namespace {

constexpr unsigned check_every =
    8;                            ///< iterations between looks at the residual; more costs more than it saves
constexpr unsigned run_ahead = 2; ///< checks that a device may lag behind the host
constexpr unsigned rebase_every = 32; ///< steps
/// Iterations at which contacts are searched anew; the set is frozen after the last, or nothing would
/// converge.
constexpr unsigned contact_search[] = {0, 8, 24};

bool searches(unsigned iteration) {
  for (unsigned at : contact_search)
    if (iteration == at) return true;
  return false;
}

} // namespace

void Simulation::step() {
  begin_step();  // obstacles and held particles at the end of the step
  begin_solve(); // y* of Eq. 12 and the first guess
  flags_.clear();
  for (unsigned k = 0; k <= iterations_; ++k) {
    const bool search = contacts_ && plan_.pairs && searches(k) && k < iterations_;
    const bool checked = k % check_every == 0 || k == iterations_ || search;
    if (search) contacts_->find(contact_state());
    local_step();    // Y*, or R and theta: Eqs. 4, 10, 11
    elastic_force(); // right side of Eq. 12
    contact_force();
    global_step(k, checked, search); // one Jacobi iteration with Chebyshev acceleration, section 4.2
    if (checked && solve_ended()) break;
  }
  restore_momentum();
  advance();
  write_statistics();
  if (++step_ % rebase_every == 0) rebase();
}

void Simulation::begin_solve() {
  State& s = *state_;
  const Vector3& g = scene_.simulation.gravity;
  device_.enter("motion");
  device_.run(kernels::predict::Args{.threads = static_cast<std::uint32_t>(plan_.particles),
                                     .bdf2 = plan_.bdf2 && !first_of_bdf2_,
                                     .loaded = plan_.loaded,
                                     .time_step = solve_step_,
                                     .gravity_x = g.x(),
                                     .gravity_y = g.y(),
                                     .gravity_z = g.z(),
                                     .position = s.position,
                                     .velocity = s.velocity,
                                     .earlier_velocity = s.earlier_velocity,
                                     .earlier_shift = s.earlier_shift,
                                     .external_force = s.external_force,
                                     .inertia_target = s.inertia_target,
                                     .displacement = s.displacement,
                                     .earlier_iterate = s.earlier_iterate});
  if (held_count_ > 0)
    device_.run(kernels::prescribe::Args{.threads = held_count_,
                                         .motion = s.motion,
                                         .held = s.held,
                                         .held_start = s.held_start,
                                         .owner = s.owner,
                                         .origin = s.origin,
                                         .position = s.position,
                                         .inertia_target = s.inertia_target,
                                         .displacement = s.displacement,
                                         .earlier_iterate = s.earlier_iterate});
  device_.copy(s.displacement, s.best_iterate);
  // The last solve ended with its stop flag up.
  device_.upload(s.solver, std::vector<double>(SOLVER_ENTRIES, 0.0));
  begin_elasticity();
}

void Simulation::begin_elasticity() {
  State& s = *state_;
  device_.enter("elasticity");
  for (const LawRange& range : model_.laws) {
    if (range.law != Law::corotated) continue;
    device_.run(kernels::corotated_begin::Args{.threads = range.count,
                                               .first = range.first,
                                               .first_slice = range.first_slice,
                                               .stride = static_cast<std::uint32_t>(plan_.particles),
                                               .unit = unit_,
                                               .slice_begin = s.slice_begin,
                                               .bond = s.bond,
                                               .weight = s.weight,
                                               .position = s.position,
                                               .shape = s.shape,
                                               .linear_start = s.linear_start});
  }
}

void Simulation::local_step() {
  State& s = *state_;
  device_.enter("elasticity");
  for (const LawRange& range : model_.laws) {
    switch (range.law) {
    case Law::corotated:
      device_.run(kernels::corotated_state::Args{.threads = range.count,
                                                 .first = range.first,
                                                 .first_slice = range.first_slice,
                                                 .stride = static_cast<std::uint32_t>(plan_.particles),
                                                 .unit = unit_,
                                                 .slice_begin = s.slice_begin,
                                                 .bond = s.bond,
                                                 .weight = s.weight,
                                                 .displacement = s.displacement,
                                                 .shape = s.shape,
                                                 .rotation = s.rotation,
                                                 .record = s.record,
                                                 .solver = s.solver});
      break;
    case Law::ordinary:
      device_.run(kernels::ordinary_state::Args{.threads = range.count,
                                                .first = range.first,
                                                .first_slice = range.first_slice,
                                                .stride = static_cast<std::uint32_t>(plan_.particles),
                                                .unit = unit_,
                                                .slice_begin = s.slice_begin,
                                                .bond = s.bond,
                                                .weight = s.weight,
                                                .position = s.position,
                                                .displacement = s.displacement,
                                                .shape = s.shape,
                                                .extension = s.extension,
                                                .solver = s.solver});
      break;
    case Law::projective:
      device_.run(kernels::projective_state::Args{.threads = range.count,
                                                  .swap_rows = swap_rows_,
                                                  .first = range.first,
                                                  .first_slice = range.first_slice,
                                                  .stride = static_cast<std::uint32_t>(plan_.particles),
                                                  .unit = unit_,
                                                  .slice_begin = s.slice_begin,
                                                  .bond = s.bond,
                                                  .weight = s.weight,
                                                  .position = s.position,
                                                  .displacement = s.displacement,
                                                  .shape = s.shape,
                                                  .record = s.record,
                                                  .solver = s.solver});
      break;
    }
  }
}

void Simulation::elastic_force() {
  State& s = *state_;
  for (const LawRange& range : model_.laws) {
    switch (range.law) {
    case Law::corotated:
      device_.run(kernels::corotated_force::Args{.threads = range.count,
                                                 .first = range.first,
                                                 .first_slice = range.first_slice,
                                                 .unit = unit_,
                                                 .slice_begin = s.slice_begin,
                                                 .bond = s.bond,
                                                 .weight = s.weight,
                                                 .record = s.record,
                                                 .linear_start = s.linear_start,
                                                 .force = s.force,
                                                 .solver = s.solver});
      break;
    case Law::ordinary:
      device_.run(kernels::ordinary_force::Args{.threads = range.count,
                                                .first = range.first,
                                                .first_slice = range.first_slice,
                                                .unit = unit_,
                                                .slice_begin = s.slice_begin,
                                                .bond = s.bond,
                                                .weight = s.weight,
                                                .position = s.position,
                                                .extension = s.extension,
                                                .linear_start = s.linear_start,
                                                .force = s.force,
                                                .solver = s.solver});
      break;
    case Law::projective:
      device_.run(kernels::projective_force::Args{.threads = range.count,
                                                  .first = range.first,
                                                  .first_slice = range.first_slice,
                                                  .unit = unit_,
                                                  .deviatoric = deviatoric_,
                                                  .slice_begin = s.slice_begin,
                                                  .bond = s.bond,
                                                  .weight = s.weight,
                                                  .position = s.position,
                                                  .record = s.record,
                                                  .linear_start = s.linear_start,
                                                  .force = s.force,
                                                  .solver = s.solver});
      break;
    }
  }
}

void Simulation::contact_force() {
  if (!contacts_) return;
  contacts_->add_forces(contact_state());
}

void Simulation::global_step(unsigned iteration, bool checked, bool restart) {
  State& s = *state_;
  const auto n = static_cast<std::uint32_t>(plan_.particles);
  device_.enter("solver");
  device_.run(kernels::chebyshev_step::Args{.threads = n,
                                            .checked = checked,
                                            .iteration = iteration,
                                            .inertia_target = s.inertia_target,
                                            .force = s.force,
                                            .displacement = s.displacement,
                                            .earlier_iterate = s.earlier_iterate,
                                            .solver = s.solver,
                                            .residual_partial = s.residual_partial});
  swap(s.displacement, s.earlier_iterate);
  if (!checked) return;
  const SolverSettings& settings = scene_.solver;
  device_.run(kernels::residual_control::Args{
      .threads = kernels::residual_control::group_size,
      .iteration = iteration,
      .partial_count = static_cast<std::uint32_t>(s.residual_partial.count()),
      .restart = restart || iteration == 0,
      .delay = std::min(settings.delay, iterations_ / 2),
      .accelerate = settings.method == "chebyshev",
      .one_minus_rho = one_minus_rho_,
      .gamma = settings.method == "chebyshev" ? settings.under_relaxation : 1.0,
      .tolerance = settings.fixed_iterations ? 0 : settings.tolerance,
      .floor_residual = settings.fixed_iterations ? 0 : floor_,
      .residual_partial = s.residual_partial,
      .solver = s.solver});
  device_.run(kernels::guard_apply::Args{.threads = n,
                                         .solver = s.solver,
                                         .displacement = s.displacement,
                                         .earlier_iterate = s.earlier_iterate,
                                         .best_iterate = s.best_iterate});
}

bool Simulation::solve_ended() {
  // The flag is on the device: iterations after it do nothing, so when the host sees it changes no bit.
  const std::size_t real = element_bytes(Type::real, device_.info().precision);
  flags_.push_back(device_.request(state_->solver, SOLVER_STOP * real, real));
  while (!flags_.empty() && (flags_.size() > run_ahead || flags_.front()->ready())) {
    const std::span<const std::byte> bytes = flags_.front()->wait();
    const bool stopped = bytes[real - 1] != std::byte{0}; // 1.0 in either precision; 0.0 is all zero bits
    flags_.pop_front();
    if (stopped) return true;
  }
  return false;
}

void Simulation::restore_momentum() {
  if (!plan_.momentum) return;
  State& s = *state_;
  device_.enter("momentum");
  const auto chunk_threads =
      static_cast<std::uint32_t>(chunks_.chunk.size()) * kernels::component_moments::group_size;
  // The rotation is found to first order: each pass leaves about a hundredth of what it found.
  const int passes = device_.info().precision == Precision::double_precision ? 5 : 2;
  for (int pass = 0; pass < passes; ++pass) {
    device_.run(kernels::component_moments::Args{.threads = chunk_threads,
                                                 .contacts = contacts_ != nullptr,
                                                 .chunk = s.chunk,
                                                 .position = s.position,
                                                 .displacement = s.best_iterate,
                                                 .inertia_target = s.inertia_target,
                                                 .touched = contacts_ ? contacts_->touched() : nullptr,
                                                 .moment = s.moment});
    device_.run(
        kernels::component_motion::Args{.threads = static_cast<std::uint32_t>(chunks_.component.size()),
                                        .component = s.component,
                                        .moment = s.moment,
                                        .rigid = s.rigid});
    device_.run(kernels::component_apply::Args{.threads = chunk_threads,
                                               .chunk = s.chunk,
                                               .rigid = s.rigid,
                                               .position = s.position,
                                               .displacement = s.best_iterate});
  }
}

void Simulation::advance() {
  State& s = *state_;
  if (plan_.energy) energies(); // of the end state, seen from its start
  const Vector3& g = scene_.simulation.gravity;
  device_.enter("motion");
  device_.run(kernels::advance::Args{.threads = static_cast<std::uint32_t>(plan_.particles),
                                     .bdf2 = plan_.bdf2 && !first_of_bdf2_,
                                     .history = plan_.bdf2,
                                     .time_step = solve_step_,
                                     .gravity_x = g.x(),
                                     .gravity_y = g.y(),
                                     .gravity_z = g.z(),
                                     .displacement = s.best_iterate,
                                     .position = s.position,
                                     .velocity = s.velocity,
                                     .earlier_velocity = s.earlier_velocity,
                                     .earlier_shift = s.earlier_shift});
  first_of_bdf2_ = false;
}

void Simulation::rebase() {
  State& s = *state_;
  device_.enter("motion");
  device_.run(kernels::rebase_origin::Args{.threads = static_cast<std::uint32_t>(model_.bodies.size()),
                                           .anchor = s.anchor,
                                           .position = s.position,
                                           .origin = s.origin,
                                           .origin_shift = s.origin_shift});
  device_.run(kernels::rebase_position::Args{.threads = static_cast<std::uint32_t>(plan_.particles),
                                             .owner = s.owner,
                                             .origin_shift = s.origin_shift,
                                             .position = s.position});
}

} // namespace pliant
