// Law M2, ordinary: the linear peridynamic solid as a projection.
#include "engine/model/plasticity.h"
#include "engine/solver/elastic_law.h"
#include "engine/solver/state.h"
#include "kernels/ordinary_energy.h"
#include "kernels/ordinary_force.h"
#include "kernels/ordinary_product.h"
#include "kernels/ordinary_product_force.h"
#include "kernels/ordinary_state.h"
#include "kernels/ordinary_tangent.h"

namespace pliant {

namespace {

class Ordinary : public ElasticLaw {
public:
  explicit Ordinary(const LawContext& context)
      : ElasticLaw(context), plastic_(can_flow(context.scene, context.model)) {}

  void state(const LawRange& range, BufferStorage* displacement) override {
    const SimulationState& s = context_.state;
    context_.device.run(
        kernels::ordinary_state::Args{.threads = range.count,
                                      .plastic = plastic_,
                                      .first = range.first,
                                      .first_slice = range.first_slice,
                                      .stride = context_.particles,
                                      .unit = context_.unit,
                                      .gate = plastic_ ? static_cast<BufferStorage*>(s.solver) : nullptr,
                                      .slice_begin = s.slice_begin,
                                      .bond = s.bond,
                                      .weight = s.weight,
                                      .position = s.position,
                                      .displacement = displacement,
                                      .shape = s.shape,
                                      .extension = s.extension,
                                      .solver = s.solver,
                                      .rest = s.rest});
  }
  void force(const LawRange& range) override {
    const SimulationState& s = context_.state;
    context_.device.run(
        kernels::ordinary_force::Args{.threads = range.count,
                                      .plastic = plastic_,
                                      .first = range.first,
                                      .first_slice = range.first_slice,
                                      .unit = context_.unit,
                                      .gate = plastic_ ? static_cast<BufferStorage*>(s.solver) : nullptr,
                                      .slice_begin = s.slice_begin,
                                      .bond = s.bond,
                                      .weight = s.weight,
                                      .position = s.position,
                                      .extension = s.extension,
                                      .linear_start = s.linear_start,
                                      .force = s.force,
                                      .solver = s.solver,
                                      .rest = s.rest});
  }
  void energy(const LawRange& range, BufferStorage* displacement, bool gated) override {
    const SimulationState& s = context_.state;
    context_.device.run(
        kernels::ordinary_energy::Args{.threads = range.count,
                                       .gated = gated,
                                       .plastic = plastic_,
                                       .first = range.first,
                                       .first_slice = range.first_slice,
                                       .stride = context_.particles,
                                       .unit = context_.unit,
                                       .gate = gated ? static_cast<BufferStorage*>(s.solver) : nullptr,
                                       .slice_begin = s.slice_begin,
                                       .bond = s.bond,
                                       .weight = s.weight,
                                       .position = s.position,
                                       .displacement = displacement,
                                       .shape = s.shape,
                                       .energy = s.energy,
                                       .rest = s.rest});
  }
  void tangent(const LawRange& range, BufferStorage*) override {
    const SimulationState& s = context_.state;
    context_.device.run(kernels::ordinary_tangent::Args{.threads = range.count,
                                                        .first = range.first,
                                                        .position = s.position,
                                                        .extension = s.extension,
                                                        .solver = s.solver,
                                                        .tangent = s.tangent});
  }
  void product(const LawRange& range, BufferStorage* direction) override {
    const SimulationState& s = context_.state;
    context_.device.run(
        kernels::ordinary_product::Args{.threads = range.count,
                                        .plastic = plastic_,
                                        .first = range.first,
                                        .first_slice = range.first_slice,
                                        .stride = context_.particles,
                                        .unit = context_.unit,
                                        .gate = plastic_ ? static_cast<BufferStorage*>(s.solver) : nullptr,
                                        .slice_begin = s.slice_begin,
                                        .bond = s.bond,
                                        .weight = s.weight,
                                        .tangent = s.tangent,
                                        .direction = direction,
                                        .shape = s.shape,
                                        .solver = s.solver,
                                        .rest = s.rest,
                                        .extension = s.extension});
    context_.device.run(kernels::ordinary_product_force::Args{.threads = range.count,
                                                              .plastic = plastic_,
                                                              .first = range.first,
                                                              .first_slice = range.first_slice,
                                                              .unit = context_.unit,
                                                              .slice_begin = s.slice_begin,
                                                              .bond = s.bond,
                                                              .weight = s.weight,
                                                              .tangent = s.tangent,
                                                              .extension = s.extension,
                                                              .solver = s.solver,
                                                              .force = s.force,
                                                              .rest = s.rest});
  }

private:
  bool plastic_;
};

} // namespace

std::unique_ptr<ElasticLaw> make_ordinary(const LawContext& context) {
  return std::make_unique<Ordinary>(context);
}

LawNeeds ordinary_needs(const LawRequest& request) {
  const std::uint32_t plastic = can_flow(request.scene, request.model);
  LawNeeds needs;
  needs.buffers = {{"extension", Type::real4, request.model.count(), ""}};
  needs.kernel(kernels::ordinary_state::Args{.plastic = plastic});
  needs.kernel(kernels::ordinary_force::Args{.plastic = plastic});
  if (request.derivative) {
    needs.kernel(kernels::ordinary_tangent::Args{});
    needs.kernel(kernels::ordinary_product::Args{.plastic = plastic});
    needs.kernel(kernels::ordinary_product_force::Args{.plastic = plastic});
  }
  for (const std::uint32_t gated : {0u, 1u})
    if (!gated || request.potential)
      needs.energies.push_back(
          kernel_variant(kernels::ordinary_energy::Args{.gated = gated, .plastic = plastic}, ""));
  return needs;
}

} // namespace pliant
