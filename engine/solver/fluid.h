// Fluids, step by step, as position-based fluids do it (Macklin and Mueller 2013; He, Wang and Wu 2017,
// section 6):
//
//   find      y* = y + h (v + h g); particles sorted into cells, lists of neighbours at y*
//   viscosity where a material has some: velocities and y*
//   bonds     where a material has some: elasticity, and at the end of the step what flows; fluid_elastic.h
//   density   iterations of a multiplier for each particle, so that none is denser than at rest, and of the
//             shifts that these make; out of obstacles after each
//   speed     velocities from what has moved so far
//   spread    redistribution and surface tension: places alone
//   finish    positions and velocities go back to their particles; what left the domain is removed
//
//   particles          position, velocity            sorted, new in each step
//   (the scene's order)    -- cells, then ids -->    fluid_place, fluid_velocity, fluid_start, lists of
//   neighbours
//
// In sorted order a particle's neighbours lie in a few straight runs, and the order depends on nothing but
// the positions. Multipliers are summed over the iterations, kept at or below zero as a sum, and a step
// starts with those of the last: a column at rest then holds itself, where starting from nothing each step it
// would sink until its bottom is dense enough to carry the rest. Where a fluid has a tensile strength they
// may pull too, up to that; of a pull nothing is kept for the next step.
//
// Velocities are what has moved in a step over the step, and that is summed on its own (fluid_moved): as a
// difference of places, rounded where they are far from where these count from, backends would differ by ten
// times as much.
#pragma once

#include "engine/device/device.h"
#include "engine/model/fluid.h"
#include "engine/plan/spec.h"
#include "engine/solver/contact_obstacles.h"
#include "engine/solver/fluid_elastic.h"
#include "engine/solver/fluid_flow.h"
#include "engine/solver/fluid_forces.h"

#include <map>
#include <memory>

namespace pliant {

struct Plan;
struct SimulationState;

/// What fluids of a scene need, each buffer and kernel under its component: "neighbours", "density",
/// "boundaries".
struct FluidPlan {
  FluidModel model;
  FluidForcePlan forces;
  FluidBonds bonds;
  FluidFlowPlan flow;
  bool walls = false;  ///< obstacles
  bool meshes = false; ///< one of them is a distance grid
  bool pulls = false;  ///< a fluid has a tensile strength
  std::uint32_t cells = 0, chunks = 0;
  std::vector<BufferSpec> buffers;
  std::vector<KernelSpec> kernels;
};
/// Throws Error(usage) as fluid_model() and Obstacles do.
FluidPlan plan_fluid(const Scene& scene, const Model& model, bool statistics);

class Fluid {
public:
  /// All must outlive it. Device coordinates are relative to `scene_origin`, m, world.
  Fluid(Device& device, const Scene& scene, const Model& model, const Plan& plan, SimulationState& state,
        const Vector3& scene_origin);

  /// From `time` to `end`, `step` later, s. Throws as FluidFlow::make_room(), before anything has changed.
  void advance(double time, double end, double step);
  FluidFlow* flow() const { return flow_.get(); } ///< null without emitters and sinks
  /// A row on its way to the host; see fluid_sum.decl.
  std::unique_ptr<Readback> sums(std::uint32_t row);
  std::unique_ptr<Readback> force_sums(std::uint32_t row); ///< see fluid_gradient_sum.decl; may be null
  const FluidPlan& plan() const { return plan_; }
  std::unique_ptr<Readback> bond_sums(std::uint32_t row); ///< see fluid_bond_sum.decl; may be null
  std::vector<double> plastic_strain() const { return elastic_->plastic_strain(); }
  std::uint32_t obstacle_count() const { return obstacles_.count(); }
  void exchange(const char* one, const char* other) { swap(buffers_.at(one), buffers_.at(other)); }
  /// A buffer by name; null when it is not in the plan.
  BufferStorage* buffer(const std::string& name) const;

private:
  template <class Args> void in_lattice(Args& args) const;
  template <class Args> void in_period(Args& args) const;
  template <class Args> void in_flight(Args& args, double step) const;
  std::vector<Real4<double>> obstacle_rows(double begin, double end) const;
  void find(double step);
  void density(double step);
  void shift();
  void project(bool spread = false);
  void spread();
  void finish(double step);

  Device& device_;
  const Scene& scene_;
  SimulationState& state_;
  bool watched_ = false; ///< statistics are wanted
  FluidPlan plan_;
  Obstacles obstacles_;
  std::map<std::string, Buffer> buffers_;
  std::unique_ptr<FluidForces> forces_;
  std::unique_ptr<FluidElastic> elastic_; ///< null without bonds
  std::unique_ptr<FluidFlow> flow_;
  Vector3 base_ = Vector3::Zero();   ///< m: where places count from, relative to the device's coordinates
  bool still_ = true;                ///< no obstacle moves
  Vector3 origin_ = Vector3::Zero(); ///< m, world: where places count from
};

} // namespace pliant
