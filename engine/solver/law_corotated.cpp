// Law M4, corotated: a rotation and a dilatation of each neighbourhood.
#include "engine/solver/elastic_law.h"
#include "engine/solver/state.h"
#include "kernels/corotated_begin.h"
#include "kernels/corotated_energy.h"
#include "kernels/corotated_force.h"
#include "kernels/corotated_product.h"
#include "kernels/corotated_state.h"
#include "kernels/corotated_tangent.h"

namespace pliant {

namespace {

class Corotated : public ElasticLaw {
public:
  using ElasticLaw::ElasticLaw;

  void begin(const LawRange& range) override {
    const SimulationState& s = context_.state;
    context_.device.run(kernels::corotated_begin::Args{.threads = range.count,
                                                       .first = range.first,
                                                       .first_slice = range.first_slice,
                                                       .stride = context_.particles,
                                                       .unit = context_.unit,
                                                       .slice_begin = s.slice_begin,
                                                       .bond = s.bond,
                                                       .weight = s.weight,
                                                       .position = s.position,
                                                       .shape = s.shape,
                                                       .linear_start = s.linear_start});
  }
  void state(const LawRange& range, BufferStorage* displacement) override {
    const SimulationState& s = context_.state;
    context_.device.run(kernels::corotated_state::Args{.threads = range.count,
                                                       .first = range.first,
                                                       .first_slice = range.first_slice,
                                                       .stride = context_.particles,
                                                       .unit = context_.unit,
                                                       .slice_begin = s.slice_begin,
                                                       .bond = s.bond,
                                                       .weight = s.weight,
                                                       .displacement = displacement,
                                                       .shape = s.shape,
                                                       .rotation = s.rotation,
                                                       .record = s.record,
                                                       .solver = s.solver});
  }
  void force(const LawRange& range) override {
    const SimulationState& s = context_.state;
    context_.device.run(kernels::corotated_force::Args{.threads = range.count,
                                                       .first = range.first,
                                                       .first_slice = range.first_slice,
                                                       .unit = context_.unit,
                                                       .slice_begin = s.slice_begin,
                                                       .bond = s.bond,
                                                       .weight = s.weight,
                                                       .record = s.record,
                                                       .linear_start = s.linear_start,
                                                       .force = s.force,
                                                       .solver = s.solver});
  }
  void energy(const LawRange& range, BufferStorage* displacement, bool gated) override {
    const SimulationState& s = context_.state;
    context_.device.run(
        kernels::corotated_energy::Args{.threads = range.count,
                                        .gated = gated,
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
                                        .rotation = s.rotation,
                                        .energy = s.energy});
  }
  void tangent(const LawRange& range, BufferStorage* displacement) override {
    const SimulationState& s = context_.state;
    context_.device.run(kernels::corotated_tangent::Args{.threads = range.count,
                                                         .first = range.first,
                                                         .first_slice = range.first_slice,
                                                         .stride = context_.particles,
                                                         .unit = context_.unit,
                                                         .slice_begin = s.slice_begin,
                                                         .bond = s.bond,
                                                         .weight = s.weight,
                                                         .displacement = displacement,
                                                         .shape = s.shape,
                                                         .rotation = s.rotation,
                                                         .solver = s.solver,
                                                         .tangent = s.tangent});
  }
  void product(const LawRange& range, BufferStorage* direction) override {
    const SimulationState& s = context_.state;
    context_.device.run(kernels::corotated_product::Args{.threads = range.count,
                                                         .first = range.first,
                                                         .first_slice = range.first_slice,
                                                         .unit = context_.unit,
                                                         .slice_begin = s.slice_begin,
                                                         .bond = s.bond,
                                                         .weight = s.weight,
                                                         .direction = direction,
                                                         .tangent = s.tangent,
                                                         .solver = s.solver,
                                                         .record = s.record});
    context_.device.run(kernels::corotated_force::Args{.threads = range.count,
                                                       .product = 1,
                                                       .first = range.first,
                                                       .first_slice = range.first_slice,
                                                       .unit = context_.unit,
                                                       .slice_begin = s.slice_begin,
                                                       .bond = s.bond,
                                                       .weight = s.weight,
                                                       .record = s.record,
                                                       .linear_start = s.linear_start,
                                                       .force = s.force,
                                                       .solver = s.solver});
  }
};

} // namespace

std::unique_ptr<ElasticLaw> make_corotated(const LawContext& context) {
  return std::make_unique<Corotated>(context);
}

LawNeeds corotated_needs(const LawRequest& request) {
  LawNeeds needs;
  const std::size_t n = request.model.count();
  needs.shape_rows = 11; // and nine of S
  needs.buffers = {{"record", Type::real4, 3 * n, ""}, {"rotation", Type::real4, n, ""}};
  needs.kernel(kernels::corotated_begin::Args{});
  needs.kernel(kernels::corotated_state::Args{});
  needs.kernel(kernels::corotated_force::Args{});
  if (request.derivative) {
    needs.kernel(kernels::corotated_tangent::Args{});
    needs.kernel(kernels::corotated_product::Args{});
    needs.kernel(kernels::corotated_force::Args{.product = 1});
  }
  needs.energy<kernels::corotated_energy::Args>(request);
  return needs;
}

} // namespace pliant
