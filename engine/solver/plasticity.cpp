// Runs the kernels of plastic flow; see plasticity.h.
#include "engine/solver/plasticity.h"

#include "engine/model/plasticity.h"
#include "engine/solver/state.h"
#include "kernels/plastic_flow.h"
#include "kernels/plastic_return.h"
#include "kernels/plastic_sum.h"

#include <algorithm>
#include <cmath>

namespace pliant {

namespace {

constexpr double unyielding = 1e30; ///< Pa; fits a float

} // namespace

PlasticFlow::PlasticFlow(Device& device, const Scene& scene, const Model& model, const Plan& plan,
                         SimulationState& state, double unit)
    : device_(device), model_(model), plan_(plan), state_(state), unit_(unit) {
  const std::vector<YieldSurface> surfaces = yield_surfaces(scene, model);
  std::vector<Real4<double>> rows(2 * model.count());
  for (std::size_t i = 0; i < model.count(); ++i) {
    const YieldSurface& surface = surfaces[i];
    const LawConstants& constants = model.constants[model.material[i]];
    rows[2 * i] = {surface.shear, surface.pressure, std::min(surface.strength, unyielding),
                   surface.hardening};
    rows[2 * i + 1] = {model.volume[i], 1 / (constants.modulus * model.volume[i]), 1 + constants.coupling, 0};
    equivalent_ = std::max(equivalent_, surface.equivalent);
  }
  device_.upload(state_.yield, rows);
  device_.upload(state_.flow, std::vector<Real4<double>>(2 * model.count(), {0, 0, 0, 0}));
  device_.upload(state_.rest, std::vector<double>(plan_.find("rest")->count, 1.0));
}

void PlasticFlow::flow() {
  SimulationState& s = state_;
  device_.enter("plasticity");
  for (const LawRange& range : model_.laws) {
    if (range.law != Law::ordinary) continue;
    device_.run(kernels::plastic_return::Args{.threads = range.count,
                                              .first = range.first,
                                              .first_slice = range.first_slice,
                                              .unit = unit_,
                                              .equivalent = equivalent_,
                                              .dimension = static_cast<double>(model_.dimension),
                                              .slice_begin = s.slice_begin,
                                              .bond = s.bond,
                                              .weight = s.weight,
                                              .rest = s.rest,
                                              .position = s.position,
                                              .displacement = s.best_iterate,
                                              .yield = s.yield,
                                              .flow = s.flow});
    device_.run(kernels::plastic_flow::Args{.threads = range.count,
                                            .first = range.first,
                                            .first_slice = range.first_slice,
                                            .unit = unit_,
                                            .slice_begin = s.slice_begin,
                                            .bond = s.bond,
                                            .weight = s.weight,
                                            .rest = s.rest,
                                            .position = s.position,
                                            .displacement = s.best_iterate,
                                            .flow = s.flow,
                                            .linear_start = s.linear_start});
  }
}

void PlasticFlow::sum(std::uint32_t row) {
  device_.enter("plasticity");
  device_.run(kernels::plastic_sum::Args{.threads = kernels::plastic_sum::group_size,
                                         .particle_count = static_cast<std::uint32_t>(model_.count()),
                                         .row = row,
                                         .flow = state_.flow,
                                         .plastic_row = state_.plastic_row});
}

std::unique_ptr<Readback> PlasticFlow::sums(std::uint32_t row) {
  sum(row);
  const std::size_t bytes = 5 * element_bytes(Type::real, device_.info().precision);
  return device_.request(state_.plastic_row, row * bytes, bytes);
}

double PlasticFlow::excess(std::uint32_t row) {
  sum(row);
  return device_.download_real(state_.plastic_row, std::size_t{5} * row + 4, 1)[0];
}

std::vector<double> PlasticFlow::strain() {
  const std::vector<Real4<double>> rows = device_.download_real4(state_.flow);
  std::vector<double> strain(model_.count());
  for (std::size_t i = 0; i < strain.size(); ++i) strain[i] = rows[2 * i].x;
  return strain;
}

} // namespace pliant
