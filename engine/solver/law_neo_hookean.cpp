// Law M5, neo-Hookean: the stress of the deformation gradient of each neighbourhood, and springs against what
// no gradient explains.
#include "engine/model/shape_tensor.h"
#include "engine/solver/elastic_law.h"
#include "engine/solver/state.h"
#include "kernels/corotated_begin.h"
#include "kernels/corotated_force.h"
#include "kernels/correspondence_energy.h"
#include "kernels/correspondence_product.h"
#include "kernels/correspondence_state.h"
#include "kernels/correspondence_tangent.h"

#include <span>

namespace pliant {

namespace {

class NeoHookean : public ElasticLaw {
public:
  using ElasticLaw::ElasticLaw;

  void upload(const LawRange& range) override {
    std::vector<double> rows(6 * std::size_t{range.count});
    for (std::uint32_t local = 0; local < range.count; ++local) {
      const std::array<double, 6> six =
          symmetric_six(shape_tensor(context_.model, range.first + local).inverse);
      for (std::size_t r = 0; r < 6; ++r) rows[r * range.count + local] = six[r];
    }
    for (std::size_t r = 0; r < 6; ++r)
      context_.device.upload(context_.state.shape, std::span(rows).subspan(r * range.count, range.count),
                             (r + 11) * context_.particles + range.first);
  }
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
    context_.device.run(kernels::correspondence_state::Args{.threads = range.count,
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
  void force(const LawRange& range) override { gather(range, false); }
  void energy(const LawRange& range, BufferStorage* displacement, bool gated) override {
    const SimulationState& s = context_.state;
    context_.device.run(
        kernels::correspondence_energy::Args{.threads = range.count,
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
    context_.device.run(kernels::correspondence_tangent::Args{.threads = range.count,
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
    context_.device.run(kernels::correspondence_product::Args{.threads = range.count,
                                                              .first = range.first,
                                                              .first_slice = range.first_slice,
                                                              .stride = context_.particles,
                                                              .unit = context_.unit,
                                                              .slice_begin = s.slice_begin,
                                                              .bond = s.bond,
                                                              .weight = s.weight,
                                                              .direction = direction,
                                                              .tangent = s.tangent,
                                                              .solver = s.solver,
                                                              .shape = s.shape,
                                                              .record = s.record});
    gather(range, true);
  }

private:
  void gather(const LawRange& range, bool product) {
    const SimulationState& s = context_.state;
    context_.device.run(kernels::corotated_force::Args{.threads = range.count,
                                                       .product = product,
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

std::unique_ptr<ElasticLaw> make_neo_hookean(const LawContext& context) {
  return std::make_unique<NeoHookean>(context);
}

LawNeeds neo_hookean_needs(const LawRequest& request) {
  LawNeeds needs;
  const std::size_t n = request.model.count();
  needs.shape_rows = 17; // and nine of S, six of the inverse shape tensor
  needs.buffers = {{"record", Type::real4, 3 * n, ""}, {"rotation", Type::real4, n, ""}};
  needs.kernel(kernels::corotated_begin::Args{});
  needs.kernel(kernels::correspondence_state::Args{});
  needs.kernel(kernels::corotated_force::Args{});
  if (request.derivative) {
    needs.kernel(kernels::correspondence_tangent::Args{});
    needs.kernel(kernels::correspondence_product::Args{});
    needs.kernel(kernels::corotated_force::Args{.product = 1});
  }
  needs.energy<kernels::correspondence_energy::Args>(request);
  return needs;
}

} // namespace pliant
