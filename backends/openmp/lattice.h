// Cells of fluids: a lattice that repeats in each direction after as many cells as there are, x fastest.
#pragma once

#include "backends/openmp/math.h"
#include "shaders/common/fluid.glsl"

namespace pliant::openmp::PLIANT_ISA {

struct LatticeCell {
  uint x, y, z;
};

/// The cell of a coordinate among `cells` that repeat; what is not finite shares one.
template <class real> PLIANT_INLINE uint lattice_axis(real x, real per_cell, uint cells) {
  const real at = x * per_cell;
  if (!(at > real(-1e9) && at < real(1e9))) return 0;
  const int cut = static_cast<int>(at), whole = static_cast<real>(cut) > at ? cut - 1 : cut;
  if (static_cast<uint>(whole) < cells) return static_cast<uint>(whole); // most are, and need no division
  const int rest = whole % static_cast<int>(cells);
  return static_cast<uint>(rest < 0 ? rest + static_cast<int>(cells) : rest);
}

/// Of kernels that bear the lattice's parameters.
template <class View, class real>
PLIANT_INLINE LatticeCell lattice_at(const View& k, const Vec3<real>& place) {
  return {lattice_axis(place.x, k.per_cell_x, k.cells_x), lattice_axis(place.y, k.per_cell_y, k.cells_y),
          lattice_axis(place.z, k.per_cell_z, k.cells_z)};
}
template <class View> PLIANT_INLINE uint lattice_number(const View& k, LatticeCell cell) {
  return (cell.z * k.cells_y + cell.y) * k.cells_x + cell.x;
}

/// Where free flight takes a particle, y + h (v + h g), and that velocity; y + h v in a nozzle.
template <class real> struct Flight {
  Vec3<real> start, place, velocity;
  bool held;
};
template <class View, class real>
PLIANT_INLINE Flight<real> free_flight(const View& k, const Real4<real>& position,
                                       const Real4<real>& velocity, const Real4<real>& origin) {
  Flight<real> flight;
  flight.start = (xyz(origin) - Vec3<real>{k.base_x, k.base_y, k.base_z}) + xyz(position);
  flight.held = velocity.w > real(FLUID_HELD) * k.time_step;
  flight.velocity = xyz(velocity);
  if (!flight.held)
    flight.velocity = flight.velocity + k.time_step * Vec3<real>{k.gravity_x, k.gravity_y, k.gravity_z};
  flight.place = flight.start + k.time_step * flight.velocity;
  return flight;
}

} // namespace pliant::openmp::PLIANT_ISA
