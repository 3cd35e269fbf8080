// Runs the kernels of each law.
#include "engine/solver/elasticity.h"

#include "engine/solver/elastic_law.h"
#include "engine/solver/inversion.h"
#include "engine/solver/state.h"

namespace pliant {

Elasticity::Elasticity(Device& device, const Scene& scene, const Model& model, SimulationState& state,
                       std::uint32_t share_row)
    : device_(device), model_(model), state_(state), unit_(model.spacing / reference_grid) {
  const auto particles = static_cast<std::uint32_t>(model.count());
  for (const LawRange& range : model.laws)
    laws_.push_back(make_law(range.law, {device, scene, model, state, particles, unit_, share_row}));
  if (resists_inversion(scene, model)) inversion_ = std::make_unique<Inversion>(device, scene, model, state);
}

Elasticity::~Elasticity() = default;

void Elasticity::upload() {
  const std::size_t n = model_.count();
  std::vector<double> shape(2 * n);
  for (std::size_t i = 0; i < n; ++i) {
    const LawConstants& constants = model_.constants[model_.material[i]];
    const bool bonded = model_.bonds.begin[i + 1] > model_.bonds.begin[i];
    shape[i] = bonded ? 1 / (constants.modulus * model_.volume[i]) : 0;
    shape[n + i] = constants.coupling;
  }
  device_.upload(state_.shape, shape);
  for (std::size_t k = 0; k < laws_.size(); ++k) laws_[k]->upload(model_.laws[k]);
  if (inversion_) inversion_->upload();
}

void Elasticity::begin() {
  device_.enter("elasticity");
  for (std::size_t k = 0; k < laws_.size(); ++k) laws_[k]->begin(model_.laws[k]);
}

void Elasticity::state(BufferStorage* displacement) {
  device_.enter("elasticity");
  for (std::size_t k = 0; k < laws_.size(); ++k) laws_[k]->state(model_.laws[k], displacement);
  if (inversion_) inversion_->state(displacement);
}

void Elasticity::force() {
  device_.enter("elasticity");
  for (std::size_t k = 0; k < laws_.size(); ++k) laws_[k]->force(model_.laws[k]);
  if (inversion_) inversion_->force();
}

void Elasticity::energy(BufferStorage* displacement, bool gated) {
  device_.enter(gated ? "elasticity" : "statistics");
  for (std::size_t k = 0; k < laws_.size(); ++k) laws_[k]->energy(model_.laws[k], displacement, gated);
  if (inversion_) inversion_->energy(displacement, gated);
}

void Elasticity::tangent(BufferStorage* displacement) {
  device_.enter("elasticity");
  for (std::size_t k = 0; k < laws_.size(); ++k) laws_[k]->tangent(model_.laws[k], displacement);
  if (inversion_) inversion_->tangent();
}

void Elasticity::product(BufferStorage* direction) {
  device_.enter("elasticity");
  for (std::size_t k = 0; k < laws_.size(); ++k) laws_[k]->product(model_.laws[k], direction);
  if (inversion_) inversion_->product(direction);
}

} // namespace pliant
