// Lame's constants of Young's modulus and Poisson's ratio, in solids and in what is flat.
#pragma once

#include "engine/model/stretch_energy.h"

namespace pliant {

struct Lame {
  double mu = 0, lambda = 0; ///< Pa
};

/// `young` in Pa. In plane stress lambda is E nu / (1 - nu^2), the one that acts within the plane.
inline Lame lame_constants(double young, double poisson, Neighbourhood neighbourhood = Neighbourhood::solid) {
  return {young / (2 * (1 + poisson)), neighbourhood == Neighbourhood::plane_stress
                                           ? young * poisson / (1 - poisson * poisson)
                                           : young * poisson / ((1 + poisson) * (1 - 2 * poisson))};
}

} // namespace pliant
