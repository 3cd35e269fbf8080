// Ghost particles: what fluids feel of walls to which they stick (He, Wang and Wu 2017, section 8, after
// Schechter and Bridson 2012). They lie inside obstacles, in as many layers as the smoothing functions reach,
// at the spacing of the fluid; they have its mass and the wall's velocity, and no force moves them.
//
//      o   o   o   o      fluid
//    ------ wall -------   half way between
//      x   x   x   x      first layer, half a spacing below
//      x   x   x   x      second
//
// Of planes they fill what lies in the domain and a little beyond; of all other shapes a lattice in their own
// axes, in line with the faces of boxes whose edges are whole spacings. Where obstacles overlap their ghosts
// would count twice: those nearer than half a spacing to one that is there already are left out.
#pragma once

#include "engine/model/model.h"

#include <vector>

namespace pliant {

struct Ghost {
  Vector3 place = Vector3::Zero(); ///< m, world, before any motion
  double depth = 0;                ///< m, below the obstacle's surface
  std::uint32_t boundary = 0;      ///< of the scene
};

/// Whether the scene has a viscous fluid and an obstacle without slip.
bool needs_ghosts(const Scene& scene);

/// Empty where needs_ghosts() is false. Throws Error(usage): a plane without slip in a scene without a
/// domain; an obstacle that lies in another, unless one of them moves; what ShapeQuery throws.
std::vector<Ghost> sample_ghosts(const Scene& scene, const Model& model);

} // namespace pliant
