// One time step, as He, Wang and Wu (2017) write it in section 4: predict, then alternate a local step, which
// finds what each particle's neighbourhood would like to be, with a global step, which moves the particles
// there.
#include "engine/core/error.h"
#include "engine/solver/contact.h"
#include "engine/solver/elasticity.h"
#include "engine/solver/failure.h"
#include "engine/solver/fluid.h"
#include "engine/solver/global_step.h"
#include "engine/solver/plasticity.h"
#include "engine/solver/simulation.h"
#include "engine/solver/state.h"
#include "kernels/all.h"
#include "shaders/common/solver.glsl"

#include <algorithm>
#include <cstring>

namespace pliant {

namespace {

constexpr unsigned run_ahead = 2;     ///< checks that a device may lag behind the host
constexpr unsigned rebase_every = 32; ///< steps
constexpr unsigned repack_every = 64; ///< steps; reads all bonds back
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
  if (fluid_) {
    advance_fluid();
    return;
  }
  begin_solving();
  do {
    while (!iterate()) {
    }
  } while (solve_again());
  end_solving();
}

void Simulation::advance_fluid() {
  begin_step();
  const double start = (static_cast<double>(step_) + double(part_) / parts_) * time_step_;
  fluid_->advance(start, (static_cast<double>(step_) + (part_ + 1.0) / parts_) * time_step_, solve_step_);
  write_statistics();
  ++step_;
}

void Simulation::begin_solving() {
  if (fluid_)
    throw Error(ExitCode::usage, "a scene of fluids has no elastic solve that could be watched or compared: "
                                 "pliant run, plan and check take it");
  begin_step();  // obstacles and held particles at the end of the step
  begin_solve(); // y* of Eq. 12 and the first guess
  flags_.clear();
  iteration_ = 0;
  plastic_rounds_ = 1, earlier_iterations_ = 0;
  flowed_ = false;
}

bool Simulation::iterate(bool look) {
  const unsigned k = iteration_++, cap = scene_.solver.iterations - earlier_iterations_;
  const bool search = plan_.pairs && searches(k) && k < cap;
  const bool checked = look || k <= 1 || k % global_step_->check_every() == 0 || k == cap || search;
  if (search) {
    if (k > 0) global_step_->restart();
    contacts_->find(contact_state(*state_));
  }
  elasticity_->state(state_->displacement); // local step: Y*, or R and theta; Eqs. 4, 10, 11
  elasticity_->force();                     // right side of Eq. 12
  if (plan_.method.potential) elasticity_->energy(state_->displacement, true); // Eq. 13
  if (contacts_) contacts_->add_forces(contact_state(*state_));
  global_step_->apply(k, checked, search); // section 4.2
  return (checked && solve_ended()) || k == cap;
}

void Simulation::end_solving() {
  restore_momentum();
  if (plastic_ && !flowed_) plastic_->flow(); // Eqs. 14 to 18
  if (failure_) failure_->break_bonds();
  advance();
  if (failure_) failure_->release();
  write_statistics();
  if (++step_ % rebase_every == 0) rebase();
  if (failure_ && step_ % repack_every == 0) failure_->repack();
}

void Simulation::begin_solve() {
  SimulationState& s = *state_;
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
                                     .displacement = s.displacement});
  if (held_count_ > 0)
    device_.run(kernels::prescribe::Args{.threads = held_count_,
                                         .motion = s.motion,
                                         .held = s.held,
                                         .held_start = s.held_start,
                                         .owner = s.owner,
                                         .origin = s.origin,
                                         .position = s.position,
                                         .inertia_target = s.inertia_target,
                                         .displacement = s.displacement});
  device_.copy(s.displacement, s.best_iterate);
  start_solver();
}

void Simulation::start_solver() {
  // The last solve ended with its stop flag up.
  device_.upload(state_->solver, std::vector<double>(SOLVER_ENTRIES, 0.0));
  elasticity_->begin();
  global_step_->begin({.step = solve_step_,
                       .stiffness_number = stiffness_number_,
                       .floor = floor_,
                       .rounding = rounding_,
                       .cap = scene_.solver.iterations - earlier_iterations_});
}

// Whatever the return took from the stresses is no longer in balance: to the same y*, from where the last
// solve ended.
bool Simulation::solve_again() {
  if (!plastic_ || plastic_rounds_ == most_plastic_rounds) return false;
  plastic_->flow();
  flowed_ = true;
  if (plastic_->excess(static_cast<std::uint32_t>(step_ % statistics_rows)) <= yield_tolerance) return false;
  static_assert(SOLVER_REASON == SOLVER_ITERATIONS + 1);
  const std::vector<double> ended = device_.download_real(state_->solver, SOLVER_ITERATIONS, 2);
  const unsigned spent = earlier_iterations_ + static_cast<unsigned>(ended[0]);
  if (ended[1] == static_cast<double>(StopReason::cap) || spent >= scene_.solver.iterations) return false;
  earlier_iterations_ = spent;
  ++plastic_rounds_;
  flowed_ = false;
  device_.copy(state_->best_iterate, state_->displacement);
  start_solver();
  flags_.clear();
  iteration_ = 0;
  return true;
}

bool Simulation::solve_ended() {
  // The flag is on the device: iterations after it do nothing, so when the host sees it changes no bit.
  const bool wide = device_.info().precision == Precision::double_precision;
  const std::size_t real = wide ? 8 : 4;
  flags_.push_back(device_.request(state_->solver, SOLVER_STOP * real, real));
  while (!flags_.empty() && (flags_.size() > run_ahead || flags_.front()->ready())) {
    const std::span<const std::byte> bytes = flags_.front()->wait();
    const double one = 1;
    const float narrow = 1;
    const void* const up = wide ? static_cast<const void*>(&one) : &narrow;
    const bool stopped = std::memcmp(bytes.data(), up, real) == 0;
    flags_.pop_front();
    if (stopped) return true;
  }
  return false;
}

void Simulation::restore_momentum() {
  if (!plan_.momentum) return;
  SimulationState& s = *state_;
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
  SimulationState& s = *state_;
  if (plan_.energy) { // of the end state, seen from its start
    device_.enter("statistics");
    elasticity_->energy(s.best_iterate);
  }
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
  SimulationState& s = *state_;
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
