// What fluids need to know before they run: constants of their smoothing functions on a lattice, and the
// cells in which neighbours are sought.
//
// A fluid's particles have no bonds. Each step sorts them into cells and lists who is near whom; cells lie in
// a lattice that repeats after as many cells as there are in each direction, so that no particle is ever
// outside: one far away only shares a cell with others that are far from it. A direction in which the domain
// repeats has a whole number of cells a period.
#pragma once

#include "engine/model/ghosts.h"
#include "engine/model/model.h"
#include "engine/model/smoothing.h"

#include <array>

namespace pliant {

/// One fluid material as kernels see it; see shaders/common/fluid.glsl.
struct FluidConstants {
  double rest = 0;      ///< kg/m^d: density of the lattice, of particles of the density typed
  double viscosity = 0; ///< Pa s
  double redistribution = 0, surface_tension = 0;
  double softness = 0; ///< 1/(kg m^2)
  double edge = 0;     ///< kg/m^(d+1): a steeper density is a surface's
  double strength = 0; ///< tensile, over the square of `rest`, Pa m^2d / kg^2
};

struct FluidLattice {
  std::array<std::uint32_t, 3> cells = {1, 1, 1};
  Vector3 edge = Vector3::Ones();   ///< m, of a cell
  Vector3 period = Vector3::Zero(); ///< m; 0 where nothing repeats
  Vector3 base = Vector3::Zero();   ///< m, world: where places count from
  std::uint32_t count() const { return cells[0] * cells[1] * cells[2]; }
};

struct FluidModel {
  std::uint32_t first = 0, count = 0, places = 0; ///< particles; places: a multiple of 16
  Smoothing smoothing;
  double reach = 0; ///< m: the smoothing functions' support
  /// m: within which places are listed. Of matter with bonds, which turns back in a step what its momentum
  /// would do, a little more: who comes within the reach in the step is felt from there on, whether or not a
  /// rounding listed it.
  double list_reach = 0;
  FluidLattice lattice;
  /// Of the cubic spline's integral beyond a wall: with it a lattice that begins half a spacing from the wall
  /// is as dense there as inside.
  double wall_share = 1;
  std::uint32_t rows = 0;                ///< that a list has room for
  std::vector<FluidConstants> constants; ///< of each fluid material, in the scene's order
  std::vector<Ghost> ghosts;             ///< numbered behind the particles
  double spacing = 0;                    ///< m
  std::uint32_t sorted() const { return count + static_cast<std::uint32_t>(ghosts.size()); }
  std::vector<std::uint32_t> kind; ///< of each particle: body, and from bit 24 on its fluid material
};

/// Throws Error(usage): more than 16 fluid materials, a period below three reaches.
FluidModel fluid_model(const Scene& scene, const Model& model);

} // namespace pliant
