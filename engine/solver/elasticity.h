// Elastic bodies in one place: which kernels each law runs, in the order of a solve.
//
//   begin     once a step: what the solve keeps of the positions at its start
//   state     local step: Y*, or R and theta, of every neighbourhood (He, Wang and Wu 2017, Eqs. 4, 10, 11)
//   force     what bonds pull with, N
//   energy    of each particle, J
//   tangent   what the derivative of the force keeps of an iterate; product: that derivative times a
//   direction
#pragma once

#include "engine/device/device.h"
#include "engine/model/model.h"

namespace pliant {

struct Scene;
struct SimulationState;

class Elasticity {
public:
  /// All must outlive it. `unit`: m, of packed bond vectors.
  Elasticity(Device& device, const Scene& scene, const Model& model, SimulationState& state);

  void begin();
  /// At y_n + displacement; leaves what force(), energy() and tangent() read.
  void state(BufferStorage* displacement);
  void force();
  /// `gated`: nothing where the solver has nothing to evaluate.
  void energy(BufferStorage* displacement, bool gated = false);
  /// Corotated and ordinary laws, of the iterate that state() saw last.
  void tangent(BufferStorage* displacement);
  /// df/du times `direction` into the buffer `force`.
  void product(BufferStorage* direction);

  double unit() const { return unit_; }
  /// Share of the deviatoric term, and the paper's row swap: projective law.
  double deviatoric() const { return deviatoric_; }
  bool swaps_rows() const { return swap_rows_; }

private:
  Device& device_;
  const Model& model_;
  SimulationState& state_;
  std::uint32_t particles_ = 0;
  double unit_ = 0, deviatoric_ = 0;
  bool swap_rows_ = false, failing_ = false;
};

} // namespace pliant
