// How stiff a scene's step is, before it is taken.
#pragma once

#include "engine/model/model.h"

namespace pliant {

struct Scene;

struct Stiffness {
  double number = 0; ///< eta = h^2 max K_i / m_i over free particles
  double noise = 0;  ///< sqrt(sum K_i^2 / D_i), sqrt(N/m): how one rounding of a bond shows in the residual
};
Stiffness stiffness_of(const Model& model, double step);

/// The scene's time step, s, shortened until a whole number of steps makes a frame.
double whole_step(const Scene& scene);

} // namespace pliant
