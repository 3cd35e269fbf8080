// The buffers of a simulation by name.
#include "engine/solver/state.h"

#include <unordered_map>

namespace pliant {

Buffer* SimulationState::find(const std::string& name) {
  const std::unordered_map<std::string, Buffer*> members{
      {"position", &position},
      {"velocity", &velocity},
      {"inertia_target", &inertia_target},
      {"displacement", &displacement},
      {"earlier_iterate", &earlier_iterate},
      {"best_iterate", &best_iterate},
      {"force", &force},
      {"linear_start", &linear_start},
      {"owner", &owner},
      {"earlier_velocity", &earlier_velocity},
      {"earlier_shift", &earlier_shift},
      {"external_force", &external_force},
      {"energy", &energy},
      {"residual", &residual},
      {"solve_partial", &solve_partial},
      {"direction", &direction},
      {"descent", &descent},
      {"preconditioned", &preconditioned},
      {"tangent", &tangent},
      {"history", &history},
      {"history_partial", &history_partial},
      {"gram", &gram},
      {"slice_begin", &slice_begin},
      {"bond", &bond},
      {"weight", &weight},
      {"shape", &shape},
      {"record", &record},
      {"rotation", &rotation},
      {"extension", &extension},
      {"inversion_shape", &inversion_shape},
      {"inversion", &inversion},
      {"inverted", &inverted},
      {"stretch_record", &stretch_record},
      {"energies", &energies},
      {"strength", &strength},
      {"toughness", &toughness},
      {"energy_before", &energy_before},
      {"released", &released},
      {"fracture", &fracture},
      {"rest", &rest},
      {"yield", &yield},
      {"flow", &flow},
      {"plastic_row", &plastic_row},
      {"emitter_count", &emitter_count},
      {"sunk", &sunk},
      {"solver", &solver},
      {"residual_partial", &residual_partial},
      {"motion", &motion},
      {"held", &held},
      {"held_start", &held_start},
      {"origin", &origin},
      {"origin_shift", &origin_shift},
      {"anchor", &anchor},
      {"chunk", &chunk},
      {"component", &component},
      {"moment", &moment},
      {"rigid", &rigid},
      {"chunk_sum", &chunk_sum},
      {"statistics", &statistics},
  };
  const auto found = members.find(name);
  return found == members.end() ? nullptr : found->second;
}

ContactState contact_state(const SimulationState& s) {
  return {.position = s.position,
          .displacement = s.displacement,
          .owner = s.owner,
          .origin = s.origin,
          .linear_start = s.linear_start,
          .solver = s.solver,
          .force = s.force,
          .slice_begin = s.slice_begin,
          .bond = s.bond,
          .energy = s.energy};
}

} // namespace pliant
