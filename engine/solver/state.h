// The buffers of a simulation by name. One that the plan leaves out is empty.
#pragma once

#include "engine/device/device.h"
#include "engine/solver/contact.h"

#include <map>

namespace pliant {

struct SimulationState {
  // Particles.
  Buffer position, velocity, inertia_target, displacement, earlier_iterate, best_iterate, force, linear_start,
      owner;
  Buffer earlier_velocity, earlier_shift; // BDF2
  Buffer external_force;                  // loads
  Buffer energy;
  // Elasticity.
  Buffer slice_begin, bond, weight, shape, record, rotation, extension;
  Buffer inversion_shape, inversion, inverted; // pushing inverted neighbourhoods back
  Buffer stretch_record, energies, strength;   // laws over basis functions; strength: of directions
  // Failure.
  Buffer toughness, energy_before, released, fracture;
  // Plasticity.
  Buffer rest, yield, flow, plastic_row;
  // What fluids gained and lost: two an emitter, particles born and whether it has ended; one a sink.
  Buffer emitter_count, sunk;
  // Solver.
  Buffer solver, residual_partial;
  // Methods with a line search.
  Buffer residual, solve_partial, direction, descent, preconditioned, tangent, history, history_partial, gram;
  // Held particles.
  Buffer motion, held, held_start;
  // Bodies and components.
  Buffer origin, origin_shift, anchor, chunk, component, moment, rigid;
  // Statistics.
  Buffer chunk_sum, statistics;

  // Divergence: what saved_state.h names, at the last state known to be good.
  std::map<std::string, Buffer> kept;

  /// The member that a name of the plan stands for.
  Buffer* find(const std::string& name);
};

/// What contacts see of it.
ContactState contact_state(const SimulationState& state);

inline constexpr std::uint32_t statistics_rows = 64; ///< steps that may be on their way to the host

} // namespace pliant
