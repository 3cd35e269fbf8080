// Factorises, and runs the kernels that solve.
#include "engine/solver/direct.h"

#include "engine/core/memory.h"
#include "engine/solver/state.h"
#include "engine/solver/stiffness.h"
#include "kernels/factor_dot.h"
#include "kernels/factor_down.h"
#include "kernels/factor_up.h"

#include <fmt/format.h>

#include <span>

namespace pliant {

namespace {

constexpr const char* component = "direct";

} // namespace

DirectPlan plan_direct(const Model& model) {
  DirectPlan plan;
  plan.dissection = dissect(model);
  // The factor twice over, in double, and once more on the device.
  require_memory(fmt::format("the direct solver's factor of {} particles needs", model.count()),
                 24 * plan.dissection.entries(), available_memory(), model.spacing);
  plan.layout = lay_out(plan.dissection);
  const FactorLayout& layout = plan.layout;
  const auto buffer = [&](const char* name, Type type, std::size_t count) {
    plan.buffers.push_back({name, type, count, component});
  };
  buffer("factor_slot", Type::uint4, layout.slot.size());
  buffer("front", Type::real4, layout.slot.size());
  buffer("factor_block_up", Type::uint4, layout.up.size());
  buffer("factor_up", Type::real, layout.coefficients_up);
  buffer("factor_block_down", Type::uint4, layout.down.size());
  buffer("factor_down", Type::real, layout.coefficients_down);
  plan.kernels = {kernel_variant(kernels::factor_up::Args{}, component),
                  kernel_variant(kernels::factor_down::Args{}, component),
                  kernel_variant(kernels::factor_dot::Args{}, component)};
  return plan;
}

Direct::Direct(const SolveContext& context) : Preconditioner(context), plan_(*context.plan.direct) {
  Device& device = context_.device;
  for (const BufferSpec& spec : plan_.buffers)
    buffers_.emplace(spec.name, device.allocate(spec.name, spec.type, spec.count));
  const FactorLayout& layout = plan_.layout;
  device.write(at("factor_slot"), 0, std::as_bytes(std::span(layout.slot)));
  device.write(at("factor_block_up"), 0, std::as_bytes(std::span(layout.up)));
  device.write(at("factor_block_down"), 0, std::as_bytes(std::span(layout.down)));
  device.upload(at("front"), std::vector<Real4<double>>(layout.slot.size(), {0, 0, 0, 0}));
  factorise_for(whole_step(context_.scene));
}

BufferStorage* Direct::at(const std::string& name) const {
  return static_cast<BufferStorage*>(buffers_.at(name));
}

void Direct::begin(const SolveBounds& bounds) {
  if (bounds.step != step_) factorise_for(bounds.step);
}

void Direct::factorise_for(double step) {
  const Factor factor = factorise(context_.model, plan_.dissection, plan_.layout, step);
  context_.device.upload(at("factor_up"), factor.up);
  context_.device.upload(at("factor_down"), factor.down);
  step_ = step;
}

void Direct::apply() {
  Device& device = context_.device;
  const SimulationState& s = context_.state;
  const FactorLayout& layout = plan_.layout;
  const std::uint32_t levels = plan_.dissection.levels;
  device.enter(component);
  for (std::uint32_t l = 0; l < levels; ++l)
    if (layout.up_begin[l + 1] > layout.up_begin[l])
      device.run(kernels::factor_up::Args{.threads = 16 * (layout.up_begin[l + 1] - layout.up_begin[l]),
                                          .first_block = layout.up_begin[l],
                                          .factor_block = at("factor_block_up"),
                                          .factor_slot = at("factor_slot"),
                                          .factor = at("factor_up"),
                                          .residual = s.residual,
                                          .solver = s.solver,
                                          .front = at("front")});
  for (std::uint32_t l = levels; l-- > 0;) // a level of empty cuts has none
    if (layout.down_begin[l + 1] > layout.down_begin[l])
      device.run(kernels::factor_down::Args{.threads = 16 * (layout.down_begin[l + 1] - layout.down_begin[l]),
                                            .first_block = layout.down_begin[l],
                                            .factor_block = at("factor_block_down"),
                                            .factor_slot = at("factor_slot"),
                                            .factor = at("factor_down"),
                                            .front = at("front"),
                                            .solver = s.solver,
                                            .preconditioned = s.preconditioned});
  device.run(kernels::factor_dot::Args{.threads = static_cast<std::uint32_t>(context_.plan.particles),
                                       .residual = s.residual,
                                       .solver = s.solver,
                                       .preconditioned = s.preconditioned,
                                       .solve_partial = s.solve_partial});
}

} // namespace pliant
