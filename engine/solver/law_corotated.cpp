// Law M4, corotated: a rotation and a dilatation of each neighbourhood.
#include "engine/solver/law_record.h"
#include "kernels/corotated_energy.h"
#include "kernels/corotated_product.h"
#include "kernels/corotated_state.h"
#include "kernels/corotated_tangent.h"

namespace pliant {

namespace {

using State = kernels::corotated_state::Args;
using Energy = kernels::corotated_energy::Args;
using Tangent = kernels::corotated_tangent::Args;
using Product = kernels::corotated_product::Args;

/// In two dimensions rotations turn about z; of what is flat the derivative is held higher.
State state_variant(const Model& model, bool failing) {
  return {.plane = model.dimension == 2, .failing = failing};
}
Tangent tangent_variant(const Model& model, bool failing) {
  return {.flat = model.dimension == 2 || model.has_sheets(), .failing = failing};
}

class Corotated : public RecordLaw<State, Energy, Tangent> {
public:
  explicit Corotated(const LawContext& context)
      : RecordLaw(context, state_variant(context.model, context.share_row > 0),
                  tangent_variant(context.model, context.share_row > 0)) {
    state_.share_row = tangent_.share_row = context.share_row;
  }

  void product(const LawRange& range, BufferStorage* direction) override {
    const SimulationState& s = context_.state;
    context_.device.run(Product{.threads = range.count,
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
    gather(range, true);
  }
};

} // namespace

std::unique_ptr<ElasticLaw> make_corotated(const LawContext& context) {
  return std::make_unique<Corotated>(context);
}

LawNeeds corotated_needs(const LawRequest& request) {
  return record_needs<State, Energy, Tangent, Product>(request, 11,
                                                       state_variant(request.model, request.failing),
                                                       tangent_variant(request.model, request.failing));
}

} // namespace pliant
