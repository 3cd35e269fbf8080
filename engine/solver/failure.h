// Bonds that break at the end of a step.
//
//   break_bonds   decides from where the step ended, never inside its iterations: bonds that are too long
//   become
//                 padding, at both ends and for good. Weights are not renormalised: a broken bond counts as
//                 one of stretch 1 in the dilatation, and the rest does not stiffen.
//   release       books the energy that was in them, as the neighbourhood's rotation finds it with and
//   without repack        drops rows of bonds that are padding in all of their 16 particles: this changes no
//   bit
#pragma once

#include "engine/device/device.h"
#include "engine/model/model.h"
#include "engine/plan/plan.h"

namespace pliant {

class Elasticity;
struct SimulationState;

class Failure {
public:
  /// All must outlive it. Throws Error(usage) as critical_stretches() does.
  Failure(Device& device, const Scene& scene, const Model& model, const Plan& plan, SimulationState& state,
          Elasticity& elasticity);

  void break_bonds();
  /// Once the energy of the same positions is there.
  void release();
  /// A row of sums on its way to the host: bonds broken, J released.
  std::unique_ptr<Readback> sums(std::uint32_t row);
  void repack();

  /// 1 less the share of the weights that is left, of every particle.
  std::vector<double> damage();

private:
  void turn_rotations();

  Device& device_;
  const Model& model_;
  const Plan& plan_;
  SimulationState& state_;
  Elasticity& elasticity_;
};

} // namespace pliant
