// Law M5, neo-Hookean: the stress of the deformation gradient of each neighbourhood, and springs against what
// no gradient explains.
#include "engine/model/shape_tensor.h"
#include "engine/solver/law_record.h"
#include "kernels/correspondence_energy.h"
#include "kernels/correspondence_product.h"
#include "kernels/correspondence_state.h"
#include "kernels/correspondence_tangent.h"

#include <span>

namespace pliant {

namespace {

using State = kernels::correspondence_state::Args;
using Energy = kernels::correspondence_energy::Args;
using Tangent = kernels::correspondence_tangent::Args;
using Product = kernels::correspondence_product::Args;

class NeoHookean : public RecordLaw<State, Energy, Tangent> {
public:
  using RecordLaw::RecordLaw;

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
  void product(const LawRange& range, BufferStorage* direction) override {
    const SimulationState& s = context_.state;
    context_.device.run(Product{.threads = range.count,
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
};

} // namespace

std::unique_ptr<ElasticLaw> make_neo_hookean(const LawContext& context) {
  return std::make_unique<NeoHookean>(context);
}

LawNeeds neo_hookean_needs(const LawRequest& request) {
  return record_needs<State, Energy, Tangent, Product>(request, 17); // six of the inverse shape tensor
}

} // namespace pliant
