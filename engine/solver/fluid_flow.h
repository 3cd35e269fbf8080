// What comes to a scene's fluids and goes from them: layers that emitters give birth to, particles that sinks
// take out. Both happen at a step's end:
//
//   make_room   before the step: which particles its layers get. Those never used first; once they are
//               spent, positions are read back, and whoever has no mass is free, in the order of particles
//   end_step    sinks take out what is in them, then the layers are born where they would be by now: at the
//               nozzle, plus what they have flown since, and fallen since it let go of them
//
// Who is born when depends on the scene and the time alone, who gets which particle on the state before the
// step: so steps are the same bit for bit on any number of threads, after a checkpoint, and when taken again.
#pragma once

#include "engine/device/device.h"
#include "engine/model/emission.h"
#include "engine/plan/spec.h"

namespace pliant {

class Fluid;
struct SimulationState;

/// What a scene's emitters and sinks need; each under the component "emitters" or "sinks".
struct FluidFlowPlan {
  std::uint32_t emitters = 0, sinks = 0;
  std::size_t points = 0, widest = 0; ///< of all nozzles; particles of the largest layer
  std::vector<BufferSpec> counts;     ///< the state's, not the fluid's
  bool used() const { return emitters + sinks > 0; }
};
FluidFlowPlan plan_flow(const Scene& scene, const Model& model);
void list_flow(FluidFlowPlan& plan, std::vector<BufferSpec>& buffers, std::vector<KernelSpec>& kernels);

/// The layers of a step.
struct FluidBirths {
  struct Layer {
    std::size_t emitter = 0;
    double born = 0;                 ///< s
    std::vector<std::uint32_t> slot; ///< a particle for each of its points, perhaps fewer for the last layer
  };
  std::vector<Layer> layers;
  std::vector<std::size_t> ended; ///< emitters that found the scene full
};

class FluidFlow {
public:
  /// All must outlive it; `origin` and `base` are where the fluid's places count from, m, in the world and on
  /// the device.
  FluidFlow(Device& device, const Scene& scene, const Model& model, const Fluid& fluid,
            SimulationState& state, const Vector3& origin, const Vector3& base);

  /// For layers born in begin <= t < end, s. Changes nothing. Throws Error(too_large) where the scene is full
  /// and an emitter is not to stop then.
  FluidBirths make_room(double begin, double end);
  void end_step(const FluidBirths& births, double end);

  /// After the state was put back: what emitters have done is read from the device.
  void reload();
  std::uint64_t emitted() const;                   ///< so far
  std::uint64_t bodies() const { return bodies_; } ///< particles at the start
  std::uint64_t emitted_by(std::size_t emitter) const { return born_[emitter]; }
  bool ended(std::size_t emitter) const { return ended_[emitter]; } ///< because the scene was full
  std::vector<std::uint32_t> sunk_by() const; ///< by each sink, so far; waits for the device
  /// The same, on their way to the host; null without sinks.
  std::unique_ptr<Readback> sunk();

private:
  bool fill(FluidBirths::Layer& layer, std::uint64_t size, std::uint64_t fresh, const FluidBirths& earlier,
            std::vector<bool>& there);

  Device& device_;
  const Scene& scene_;
  const Fluid& fluid_;
  SimulationState& state_;
  Vector3 base_;
  std::vector<Emission> emissions_;
  std::vector<std::uint32_t> first_point_; ///< in emitter_point
  std::uint64_t capacity_ = 0, bodies_ = 0;
  bool leave_ = false;
  std::vector<std::uint32_t> born_, ended_; ///< of each emitter: particles so far; whether it has ended
};

} // namespace pliant
