// The state of a simulation taken and put back, and steps in parts.
#include "engine/solver/saved_state.h"

#include "engine/core/error.h"
#include "engine/solver/fluid.h"
#include "engine/solver/simulation.h"
#include "engine/solver/state.h"

#include <fmt/format.h>

#include <algorithm>

namespace pliant {

std::vector<std::string> persistent_buffers(const Plan& plan) {
  std::vector<std::string> names = {
      "position",         // with the mass
      "velocity",         // with the share of gravity that was felt
      "origin",           // of bodies: moved every so many steps
      "rotation",         // corotated and neo-Hookean laws: where the next polar decomposition starts
      "earlier_velocity", // BDF2
      "earlier_shift",    // BDF2
  };
  if (plan.failure) // who is bonded, how stiffly, how much of the weights is left, K_i, and the energy
                    // released so far
    for (const char* name :
         {"slice_begin", "bond", "weight", "strength", "shape", "linear_start", "released"})
      names.emplace_back(name);
  if (plan.plastic) // lengths of bonds at rest, what led to them, and K_i
    for (const char* name : {"rest", "flow", "linear_start"})
      if (std::find(names.begin(), names.end(), name) == names.end()) names.emplace_back(name);
  if (plan.fluid_bonds) // of fluids: who was near whom, where, and at what lengths bonds rest
    for (const char* name : {"near_count", "near", "near_rest", "near_place_of"}) names.emplace_back(name);
  if (plan.fluid_flow) names.emplace_back("fluid_flow");
  if (plan.fluid_sources) // who was born, who was taken out
    for (const char* name : {"emitter_count", "sunk"}) names.emplace_back(name);
  return names;
}

BufferStorage* Simulation::persistent(const std::string& name) const {
  if (Buffer* const buffer = state_->find(name)) return *buffer;
  return fluid_ ? fluid_->buffer(name) : nullptr;
}

SavedState Simulation::save() {
  SavedState saved{step_, first_of_bdf2_, {}};
  for (const std::string& name : persistent_buffers(plan_)) {
    if (!plan_.find(name)) continue;
    BufferStorage* const buffer = persistent(name);
    SavedBuffer copy{name, buffer->type(), std::vector<std::byte>(buffer->bytes())};
    device_.read(buffer, 0, copy.bytes);
    saved.buffers.push_back(std::move(copy));
  }
  return saved;
}

void Simulation::load(const SavedState& saved) {
  std::size_t fitting = 0, wanted = 0;
  for (const std::string& name : persistent_buffers(plan_)) wanted += plan_.find(name) ? 1 : 0;
  for (const SavedBuffer& copy : saved.buffers) {
    BufferStorage* const buffer = plan_.find(copy.name) ? persistent(copy.name) : nullptr;
    if (!buffer || buffer->type() != copy.type || buffer->bytes() != copy.bytes.size())
      throw Error(ExitCode::internal,
                  fmt::format("a saved state whose buffer '{}' of {} bytes is none of this simulation's",
                              copy.name, copy.bytes.size()));
    ++fitting;
  }
  if (fitting != wanted)
    throw Error(
        ExitCode::internal,
        fmt::format("a saved state of {} buffers given to a simulation that has {}", fitting, wanted));
  for (const SavedBuffer& copy : saved.buffers) device_.write(persistent(copy.name), 0, copy.bytes);
  step_ = saved.step;
  first_of_bdf2_ = saved.first_of_bdf2;
  if (fluid_ && fluid_->flow()) fluid_->flow()->reload();
  if (plan_.held) held_count_ = ~0u; // whoever is held at the new time is sent again
  pending_.clear();
}

void Simulation::keep() {
  device_.enter("divergence");
  for (const auto& [name, copy] : state_->kept) device_.copy(persistent(name), copy);
  kept_step_ = step_;
  kept_first_of_bdf2_ = first_of_bdf2_;
}

void Simulation::rewind() {
  if (!plan_.divergence)
    throw Error(ExitCode::internal, "no state is kept: divergence is not in this simulation's plan");
  for (const auto& [name, copy] : state_->kept) device_.copy(copy, persistent(name));
  step_ = kept_step_;
  first_of_bdf2_ = kept_first_of_bdf2_;
  if (fluid_ && fluid_->flow()) fluid_->flow()->reload();
  if (plan_.held) held_count_ = ~0u;
  pending_.clear();
}

void Simulation::step_divided(unsigned parts) {
  const std::uint64_t start = step_;
  if (fluid_ && fluid_->flow()) // a scene that is full ends before a step, not within
    fluid_->flow()->make_room(double(start) * time_step_, (double(start) + 1) * time_step_);
  parts_ = parts;
  for (part_ = 0; part_ < parts; ++part_) {
    step_ = start;
    first_of_bdf2_ = true; // steps of another length are no history
    step();
  }
  parts_ = 1;
  part_ = 0;
  first_of_bdf2_ = true;
}

} // namespace pliant
