// Laws over bonds feel lengths only, so that a mirror image is at rest like the body itself. Materials that
// ask for it are pushed back out of inverted states: see kernels/inversion_state.decl. It runs beside the
// laws, adding to what they leave, for the ranges of particles that have such a material.
#pragma once

#include "engine/device/device.h"
#include "engine/model/model.h"
#include "engine/plan/spec.h"

namespace pliant {

struct Scene;
struct SimulationState;

/// Whether a material is pushed out of inverted states: inversion = "clamp". The projective law does it in
/// its own way, the corotated one needs no help.
bool resists_inversion(const Material& material);
/// Whether any particle is of such a material.
bool resists_inversion(const Scene& scene, const Model& model);

/// What the plan must have for it. Names of components stay empty.
struct InversionNeeds {
  std::vector<BufferSpec> buffers;
  std::vector<KernelSpec> kernels, energies; ///< energies: at the end of a step; where the line search looks
};
InversionNeeds inversion_needs(const Model& model, bool derivative, bool potential);

class Inversion {
public:
  /// All must outlive it.
  Inversion(Device& device, const Scene& scene, const Model& model, SimulationState& state);

  /// Once: constants of every particle.
  void upload();
  /// After the laws' own; the same arguments as Elasticity's.
  void state(BufferStorage* displacement);
  void force();
  void energy(BufferStorage* displacement, bool gated);
  void tangent();
  void product(BufferStorage* direction);

private:
  void gather(const LawRange& range, bool product);

  Device& device_;
  const Scene& scene_;
  const Model& model_;
  SimulationState& state_;
  std::vector<LawRange> ranges_;
  std::uint32_t particles_ = 0;
  double unit_ = 0;
};

} // namespace pliant
