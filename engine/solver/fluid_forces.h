// What acts on fluids besides incompressibility (He, Wang and Wu 2017, section 6):
//
//   ghosts          walls to which fluids stick, sorted in among the particles
//   viscosity       implicit, (M + h A) v = M v*, before the density constraint; conjugate gradients on the
//   device redistribution  after the velocities are known: places alone, so that particles spread evenly at
//   no cost of
//                   motion; and surface tension with it
//
// Each is left out of the plan where no material or obstacle of the scene asks for it.
#pragma once

#include "engine/device/device.h"
#include "engine/model/fluid.h"
#include "engine/plan/spec.h"

#include <memory>

namespace pliant {

class Fluid;

/// What a scene's fluids need of it.
struct FluidForcePlan {
  bool ghosts = false;
  bool viscous = false, viscosities = false; ///< more than one
  bool central = false;                      ///< viscous forces along lines of centres
  bool spread = false, tension = false, masses = false;
  std::uint32_t form = 0; ///< of the redistribution; see fluid_redistribute.decl
  double sign = 1;        ///< of form 2
};
FluidForcePlan plan_forces(const Scene& scene, const Model& model, const FluidModel& fluid);
/// Their buffers and kernels, under the components "ghosts", "viscosity" and "redistribution".
void list_forces(const FluidForcePlan& plan, const FluidModel& fluid, bool statistics,
                 std::vector<BufferSpec>& buffers, std::vector<KernelSpec>& kernels);

/// Columns of a row of spread_row: see fluid_gradient_sum.decl.
inline constexpr std::size_t spread_columns = 8;

class FluidForces {
public:
  /// All must outlive it; `origin` is where places count from, m, world.
  FluidForces(Device& device, const Scene& scene, const Fluid& fluid, const Vector3& origin);

  /// Where ghosts are at `end`, and their velocities since `begin`, s.
  void move_ghosts(double begin, double end);
  void sort_ghosts();   ///< their cells, after those of the particles
  void gather_ghosts(); ///< into sorted order
  /// Changes fluid_velocity, and fluid_place accordingly.
  void viscosity(double step);
  /// One sweep from fluid_place to fluid_shift.
  void spread();
  /// A row of statistics on its way to the host; null where there is nothing to say.
  std::unique_ptr<Readback> sums(std::uint32_t row);

private:
  Device& device_;
  const Scene& scene_;
  const Fluid& fluid_;
  Vector3 origin_;
  double ghost_mass_ = 0; ///< kg
  bool ghosts_stand_ = false;
};

} // namespace pliant
