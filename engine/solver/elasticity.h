// Elastic bodies in one place: every range of particles runs the kernels of its law (elastic_law.h), in the
// order of a solve.
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

#include <memory>
#include <vector>

namespace pliant {

class ElasticLaw;
class Inversion;
struct Scene;
struct SimulationState;

class Elasticity {
public:
  /// All must outlive it.
  /// `share_row`: of `shape`, where bonds break; else 0.
  Elasticity(Device& device, const Scene& scene, const Model& model, SimulationState& state,
             std::uint32_t share_row);
  ~Elasticity();
  Elasticity(const Elasticity&) = delete;
  Elasticity& operator=(const Elasticity&) = delete;

  /// Once: the laws' constants of every particle.
  void upload();

  void begin();
  /// At y_n + displacement; leaves what force(), energy() and tangent() read.
  void state(BufferStorage* displacement);
  void force();
  /// `gated`: nothing where the solver has nothing to evaluate.
  void energy(BufferStorage* displacement, bool gated = false);
  /// Of laws with a potential, of the iterate that state() saw last.
  void tangent(BufferStorage* displacement);
  /// df/du times `direction` into the buffer `force`.
  void product(BufferStorage* direction);

  /// m, of packed bond vectors.
  double unit() const { return unit_; }

private:
  Device& device_;
  const Model& model_;
  SimulationState& state_;
  double unit_ = 0;
  std::vector<std::unique_ptr<ElasticLaw>> laws_; ///< of each of the model's ranges
  std::unique_ptr<Inversion> inversion_;          ///< null where no material asks for it
};

} // namespace pliant
