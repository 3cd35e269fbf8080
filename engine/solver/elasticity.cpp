// Runs the kernels of each law.
#include "engine/solver/elasticity.h"

#include "engine/model/failure.h"
#include "engine/solver/state.h"
#include "kernels/all.h"

namespace pliant {

Elasticity::Elasticity(Device& device, const Scene& scene, const Model& model, SimulationState& state)
    : device_(device), model_(model), state_(state), particles_(static_cast<std::uint32_t>(model.count())),
      unit_(model.spacing / reference_grid), failing_(can_break(scene, model)) {
  for (const Material& material : scene.materials) {
    if (material.law != law_name(Law::projective)) continue;
    deviatoric_ = material.split;
    swap_rows_ = material.inversion == "swap";
  }
}

void Elasticity::begin() {
  SimulationState& s = state_;
  device_.enter("elasticity");
  for (const LawRange& range : model_.laws) {
    if (range.law != Law::corotated) continue;
    device_.run(kernels::corotated_begin::Args{.threads = range.count,
                                               .first = range.first,
                                               .first_slice = range.first_slice,
                                               .stride = particles_,
                                               .unit = unit_,
                                               .slice_begin = s.slice_begin,
                                               .bond = s.bond,
                                               .weight = s.weight,
                                               .position = s.position,
                                               .shape = s.shape,
                                               .linear_start = s.linear_start});
  }
}

void Elasticity::state(BufferStorage* displacement) {
  SimulationState& s = state_;
  device_.enter("elasticity");
  for (const LawRange& range : model_.laws) {
    switch (range.law) {
    case Law::corotated:
      device_.run(kernels::corotated_state::Args{.threads = range.count,
                                                 .failing = failing_,
                                                 .first = range.first,
                                                 .first_slice = range.first_slice,
                                                 .stride = particles_,
                                                 .unit = unit_,
                                                 .slice_begin = s.slice_begin,
                                                 .bond = s.bond,
                                                 .weight = s.weight,
                                                 .displacement = displacement,
                                                 .shape = s.shape,
                                                 .rotation = s.rotation,
                                                 .record = s.record,
                                                 .solver = s.solver});
      break;
    case Law::ordinary:
      device_.run(kernels::ordinary_state::Args{.threads = range.count,
                                                .first = range.first,
                                                .first_slice = range.first_slice,
                                                .stride = particles_,
                                                .unit = unit_,
                                                .slice_begin = s.slice_begin,
                                                .bond = s.bond,
                                                .weight = s.weight,
                                                .position = s.position,
                                                .displacement = displacement,
                                                .shape = s.shape,
                                                .extension = s.extension,
                                                .solver = s.solver});
      break;
    case Law::projective:
      device_.run(kernels::projective_state::Args{.threads = range.count,
                                                  .swap_rows = swap_rows_,
                                                  .first = range.first,
                                                  .first_slice = range.first_slice,
                                                  .stride = particles_,
                                                  .unit = unit_,
                                                  .slice_begin = s.slice_begin,
                                                  .bond = s.bond,
                                                  .weight = s.weight,
                                                  .position = s.position,
                                                  .displacement = displacement,
                                                  .shape = s.shape,
                                                  .record = s.record,
                                                  .solver = s.solver});
      break;
    }
  }
}

void Elasticity::force() {
  SimulationState& s = state_;
  device_.enter("elasticity");
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

void Elasticity::energy(BufferStorage* displacement, bool gated) {
  SimulationState& s = state_;
  device_.enter(gated ? "elasticity" : "statistics");
  for (const LawRange& range : model_.laws) {
    switch (range.law) {
    case Law::corotated:
      device_.run(
          kernels::corotated_energy::Args{.threads = range.count,
                                          .gated = gated,
                                          .first = range.first,
                                          .first_slice = range.first_slice,
                                          .stride = particles_,
                                          .unit = unit_,
                                          .gate = gated ? static_cast<BufferStorage*>(s.solver) : nullptr,
                                          .slice_begin = s.slice_begin,
                                          .bond = s.bond,
                                          .weight = s.weight,
                                          .position = s.position,
                                          .displacement = displacement,
                                          .shape = s.shape,
                                          .rotation = s.rotation,
                                          .energy = s.energy});
      break;
    case Law::ordinary:
      device_.run(
          kernels::ordinary_energy::Args{.threads = range.count,
                                         .gated = gated,
                                         .first = range.first,
                                         .first_slice = range.first_slice,
                                         .stride = particles_,
                                         .unit = unit_,
                                         .gate = gated ? static_cast<BufferStorage*>(s.solver) : nullptr,
                                         .slice_begin = s.slice_begin,
                                         .bond = s.bond,
                                         .weight = s.weight,
                                         .position = s.position,
                                         .displacement = displacement,
                                         .shape = s.shape,
                                         .energy = s.energy});
      break;
    case Law::projective:
      device_.run(
          kernels::projective_energy::Args{.threads = range.count,
                                           .gated = gated,
                                           .first = range.first,
                                           .first_slice = range.first_slice,
                                           .unit = unit_,
                                           .deviatoric = deviatoric_,
                                           .gate = gated ? static_cast<BufferStorage*>(s.solver) : nullptr,
                                           .slice_begin = s.slice_begin,
                                           .bond = s.bond,
                                           .weight = s.weight,
                                           .position = s.position,
                                           .record = s.record,
                                           .energy = s.energy});
      break;
    }
  }
}

void Elasticity::tangent(BufferStorage* displacement) {
  SimulationState& s = state_;
  device_.enter("elasticity");
  for (const LawRange& range : model_.laws) {
    if (range.law == Law::corotated)
      device_.run(kernels::corotated_tangent::Args{.threads = range.count,
                                                   .failing = failing_,
                                                   .first = range.first,
                                                   .first_slice = range.first_slice,
                                                   .stride = particles_,
                                                   .unit = unit_,
                                                   .slice_begin = s.slice_begin,
                                                   .bond = s.bond,
                                                   .weight = s.weight,
                                                   .displacement = displacement,
                                                   .shape = s.shape,
                                                   .rotation = s.rotation,
                                                   .solver = s.solver,
                                                   .tangent = s.tangent});
    if (range.law == Law::ordinary)
      device_.run(kernels::ordinary_tangent::Args{.threads = range.count,
                                                  .first = range.first,
                                                  .position = s.position,
                                                  .extension = s.extension,
                                                  .solver = s.solver,
                                                  .tangent = s.tangent});
  }
}

void Elasticity::product(BufferStorage* direction) {
  SimulationState& s = state_;
  device_.enter("elasticity");
  for (const LawRange& range : model_.laws) {
    if (range.law == Law::corotated) {
      device_.run(kernels::corotated_product::Args{.threads = range.count,
                                                   .first = range.first,
                                                   .first_slice = range.first_slice,
                                                   .unit = unit_,
                                                   .slice_begin = s.slice_begin,
                                                   .bond = s.bond,
                                                   .weight = s.weight,
                                                   .direction = direction,
                                                   .tangent = s.tangent,
                                                   .solver = s.solver,
                                                   .record = s.record});
      device_.run(kernels::corotated_force::Args{.threads = range.count,
                                                 .product = 1,
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
    }
    if (range.law == Law::ordinary) {
      device_.run(kernels::ordinary_product::Args{.threads = range.count,
                                                  .first = range.first,
                                                  .first_slice = range.first_slice,
                                                  .stride = particles_,
                                                  .unit = unit_,
                                                  .slice_begin = s.slice_begin,
                                                  .bond = s.bond,
                                                  .weight = s.weight,
                                                  .tangent = s.tangent,
                                                  .direction = direction,
                                                  .shape = s.shape,
                                                  .solver = s.solver,
                                                  .extension = s.extension});
      device_.run(kernels::ordinary_product_force::Args{.threads = range.count,
                                                        .first = range.first,
                                                        .first_slice = range.first_slice,
                                                        .unit = unit_,
                                                        .slice_begin = s.slice_begin,
                                                        .bond = s.bond,
                                                        .weight = s.weight,
                                                        .tangent = s.tangent,
                                                        .extension = s.extension,
                                                        .solver = s.solver,
                                                        .force = s.force});
    }
  }
}

} // namespace pliant
