// What the corotated and the neo-Hookean law have in common: a local step that leaves a matrix A_i at each
// particle, from which one kernel gathers f_i = sum (c_ij + c_ji) Y - (c_ij A_i + c_ji A_j) xi. They differ
// in A.
#pragma once

#include "engine/solver/elastic_law.h"
#include "engine/solver/state.h"
#include "kernels/corotated_begin.h"
#include "kernels/corotated_force.h"

namespace pliant {

template <class StateArgs, class EnergyArgs, class TangentArgs> class RecordLaw : public ElasticLaw {
public:
  /// The local step and its derivative with the options that the scene needs.
  explicit RecordLaw(const LawContext& context, const StateArgs& state = {}, const TangentArgs& tangent = {})
      : ElasticLaw(context), state_(state), tangent_(tangent) {}

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
    StateArgs args = state_;
    args.threads = range.count;
    args.first = range.first;
    args.first_slice = range.first_slice;
    args.stride = context_.particles;
    args.unit = context_.unit;
    args.slice_begin = s.slice_begin;
    args.bond = s.bond;
    args.weight = s.weight;
    args.displacement = displacement;
    args.shape = s.shape;
    args.rotation = s.rotation;
    args.record = s.record;
    args.solver = s.solver;
    context_.device.run(args);
  }
  void force(const LawRange& range) override { gather(range, false); }
  void energy(const LawRange& range, BufferStorage* displacement, bool gated) override {
    const SimulationState& s = context_.state;
    context_.device.run(EnergyArgs{.threads = range.count,
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
    TangentArgs args = tangent_;
    args.threads = range.count;
    args.first = range.first;
    args.first_slice = range.first_slice;
    args.stride = context_.particles;
    args.unit = context_.unit;
    args.slice_begin = s.slice_begin;
    args.bond = s.bond;
    args.weight = s.weight;
    args.displacement = displacement;
    args.shape = s.shape;
    args.rotation = s.rotation;
    args.solver = s.solver;
    args.tangent = s.tangent;
    context_.device.run(args);
  }

protected:
  /// Of the record: forces, or with `product` their derivative.
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

  StateArgs state_;
  TangentArgs tangent_;
};

/// `rows` of `shape`: the two that all laws have, nine of S, and the law's own.
template <class StateArgs, class EnergyArgs, class TangentArgs, class ProductArgs>
LawNeeds record_needs(const LawRequest& request, std::size_t rows, const StateArgs& state = {},
                      const TangentArgs& tangent = {}) {
  LawNeeds needs;
  const std::size_t n = request.model.count();
  needs.shape_rows = rows;
  needs.buffers = {{"record", Type::real4, 3 * n, ""}, {"rotation", Type::real4, n, ""}};
  needs.kernel(kernels::corotated_begin::Args{});
  needs.kernel(state);
  needs.kernel(kernels::corotated_force::Args{});
  if (request.derivative) {
    needs.kernel(tangent);
    needs.kernel(ProductArgs{});
    needs.kernel(kernels::corotated_force::Args{.product = 1});
  }
  needs.energy<EnergyArgs>(request);
  return needs;
}

} // namespace pliant
