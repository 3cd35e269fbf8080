// Triangles small enough to tear between particles.
#pragma once

#include "engine/scene/mesh.h"

namespace pliant {

/// Halves edges longer than `longest` (m) until none is, in both of their triangles alike: the surface stays
/// as closed as it was, vertices keep their numbers, and new ones lie on its triangles.
Mesh refine(Mesh mesh, double longest);

} // namespace pliant
