// Runs the kernels against inversion.
#include "engine/solver/inversion.h"

#include "engine/model/shape_tensor.h"
#include "engine/scene/scene.h"
#include "engine/solver/state.h"
#include "kernels/inversion_energy.h"
#include "kernels/inversion_force.h"
#include "kernels/inversion_product.h"
#include "kernels/inversion_state.h"
#include "kernels/inversion_tangent.h"

#include <algorithm>

namespace pliant {

namespace {

constexpr std::size_t rows = 9; ///< of `inversion_shape`, see kernels/inversion_state.decl

bool resists_inversion(const Scene& scene, const Model& model, const LawRange& range) {
  for (std::uint32_t i = range.first; i < range.first + range.count; ++i)
    if (pliant::resists_inversion(typed_material(scene, model, i)) &&
        model.bodies[model.body[i]].thickness == 0)
      return true;
  return false; // what is flat has no inside
}

} // namespace

bool resists_inversion(const Material& material) {
  return material.inversion == "clamp" && may_invert(material) && law_of(material) != Law::projective;
}

bool resists_inversion(const Scene& scene, const Model& model) {
  return std::any_of(model.laws.begin(), model.laws.end(),
                     [&](const LawRange& range) { return resists_inversion(scene, model, range); });
}

InversionNeeds inversion_needs(const Model& model, bool derivative, bool potential) {
  InversionNeeds needs;
  const std::size_t n = model.count();
  const auto kernel = [](const auto& args) { return kernel_variant(args, ""); };
  needs.buffers = {{"inversion_shape", Type::real, rows * n, ""}, {"inversion", Type::real4, 3 * n, ""}};
  needs.kernels = {kernel(kernels::inversion_state::Args{}), kernel(kernels::inversion_force::Args{})};
  if (derivative) {
    needs.buffers.push_back({"inverted", Type::real, n, ""});
    needs.kernels.push_back(kernel(kernels::inversion_tangent::Args{}));
    needs.kernels.push_back(kernel(kernels::inversion_product::Args{}));
    needs.kernels.push_back(kernel(kernels::inversion_force::Args{.product = 1}));
  }
  needs.energies = {kernel(kernels::inversion_energy::Args{})};
  if (potential) needs.energies.push_back(kernel(kernels::inversion_energy::Args{.gated = 1}));
  return needs;
}

Inversion::Inversion(Device& device, const Scene& scene, const Model& model, SimulationState& state)
    : device_(device), scene_(scene), model_(model), state_(state),
      particles_(static_cast<std::uint32_t>(model.count())), unit_(model.spacing / reference_grid) {
  for (const LawRange& range : model.laws)
    if (resists_inversion(scene, model, range)) ranges_.push_back(range);
}

void Inversion::upload() {
  const std::size_t n = model_.count();
  std::vector<double> shape(rows * n, 0.0);
  for (const LawRange& range : ranges_)
    for (std::uint32_t i = range.first; i < range.first + range.count; ++i) {
      if (!pliant::resists_inversion(typed_material(scene_, model_, i))) continue;
      const ShapeTensor tensor = shape_tensor(model_, i);
      if (tensor.rank < 3) continue; // sheets and threads have no inside
      const LawConstants& constants = model_.constants[model_.material[i]];
      // k is the stiffness that the solver gives a bond: more than any bond pulls towards the mirror image.
      const double push = constants.bound / 3;
      shape[i] = 1 / (constants.modulus * model_.volume[i]);
      shape[n + i] = push;
      shape[2 * n + i] = push / tensor.least;
      const std::array<double, 6> six = symmetric_six(tensor.inverse);
      for (std::size_t r = 0; r < 6; ++r) shape[(r + 3) * n + i] = six[r];
    }
  device_.upload(state_.inversion_shape, shape);
}

void Inversion::state(BufferStorage* displacement) {
  const SimulationState& s = state_;
  device_.enter("inversion");
  for (const LawRange& range : ranges_)
    device_.run(kernels::inversion_state::Args{.threads = range.count,
                                               .first = range.first,
                                               .first_slice = range.first_slice,
                                               .stride = particles_,
                                               .unit = unit_,
                                               .slice_begin = s.slice_begin,
                                               .bond = s.bond,
                                               .weight = s.weight,
                                               .position = s.position,
                                               .displacement = displacement,
                                               .inversion_shape = s.inversion_shape,
                                               .inversion = s.inversion,
                                               .solver = s.solver});
}

void Inversion::force() {
  for (const LawRange& range : ranges_) gather(range, false);
}

void Inversion::energy(BufferStorage* displacement, bool gated) {
  const SimulationState& s = state_;
  for (const LawRange& range : ranges_)
    device_.run(
        kernels::inversion_energy::Args{.threads = range.count,
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
                                        .inversion_shape = s.inversion_shape,
                                        .energy = s.energy});
}

void Inversion::tangent() {
  const SimulationState& s = state_;
  for (const LawRange& range : ranges_)
    device_.run(kernels::inversion_tangent::Args{.threads = range.count,
                                                 .first = range.first,
                                                 .inversion = s.inversion,
                                                 .solver = s.solver,
                                                 .inverted = s.inverted});
}

void Inversion::product(BufferStorage* direction) {
  const SimulationState& s = state_;
  for (const LawRange& range : ranges_) {
    device_.run(kernels::inversion_product::Args{.threads = range.count,
                                                 .first = range.first,
                                                 .first_slice = range.first_slice,
                                                 .stride = particles_,
                                                 .unit = unit_,
                                                 .slice_begin = s.slice_begin,
                                                 .bond = s.bond,
                                                 .weight = s.weight,
                                                 .direction = direction,
                                                 .inversion_shape = s.inversion_shape,
                                                 .inverted = s.inverted,
                                                 .solver = s.solver,
                                                 .inversion = s.inversion});
    gather(range, true);
  }
}

void Inversion::gather(const LawRange& range, bool product) {
  const SimulationState& s = state_;
  device_.run(kernels::inversion_force::Args{.threads = range.count,
                                             .product = product,
                                             .first = range.first,
                                             .first_slice = range.first_slice,
                                             .unit = unit_,
                                             .slice_begin = s.slice_begin,
                                             .bond = s.bond,
                                             .weight = s.weight,
                                             .inversion = s.inversion,
                                             .force = s.force,
                                             .solver = s.solver});
}

} // namespace pliant
