// The elastic part of fluids that have some (engine/model/fluid_bonds.h): bonds between the neighbours of
// now, an implicit solve, and the rest lengths that it leaves.
//
//   carry   after the lists: rest lengths of pairs that were neighbours before, of new ones from what both
//           ends know of their deformation (Eq. 20 of He, Wang and Wu 2017, in lengths)
//   solve   after viscosity: min 1/2 sum m/h^2 |u - u*|^2 + W, by Jacobi's iteration with Chebyshev's
//           acceleration and its guard, obstacles in it as penalties. What flows in the step, flows in it:
//           forces are those of the stress that stays, so that a step drives nothing with stresses beyond
//           what the material bears, however long it is
//   settle  after the density constraint: the return to the yield surface, for good
//   hold    after particles were spread evenly: those that did not flow go back to where they were
//   flow    rest lengths
//
// The next step needs of this one its lists, the rest lengths in their order, who was where, and plastic
// strains.
#pragma once

#include "engine/device/device.h"
#include "engine/model/fluid_bonds.h"
#include "engine/plan/spec.h"

#include <memory>

namespace pliant {

class Fluid;
struct FluidPlan;
struct SimulationState;

/// Buffers and kernels under the components "bonds", "elasticity" and "plasticity".
void list_bonds(FluidPlan& plan, bool statistics);

/// Columns of a row of bond_row: see fluid_bond_sum.decl.
inline constexpr std::size_t bond_columns = 6;

class FluidElastic {
public:
  /// All must outlive it.
  FluidElastic(Device& device, const Scene& scene, Fluid& fluid, SimulationState& state);

  void keep_lists(); ///< before new ones are made
  void carry();
  void solve(double step);
  void settle(bool measured);
  void hold();
  void flow();
  /// A row of statistics on its way to the host.
  std::unique_ptr<Readback> sums(std::uint32_t row);
  std::vector<double> plastic_strain() const; ///< of each particle

private:
  template <class Args> void in_lists(Args& args) const;
  template <class Args> void in_space(Args& args) const;
  template <class Args> void in_bonds(Args& args) const;
  void upload_materials(double step);
  void forces(bool first);
  bool check(unsigned iteration, double step);

  Device& device_;
  const Scene& scene_;
  Fluid& fluid_;
  SimulationState& state_;
  double step_ = 0; ///< s, that the table of materials is of
};

} // namespace pliant
