// When bonds break: the stretch that a material bears, and cuts that bodies have from the start.
#pragma once

#include "engine/model/model.h"

namespace pliant {

/// Normals of the planes along which cracks are reckoned: those of the lattice's faces, in the body's axes.
/// In what is flat along the particle's shortest bond and across it, in its plane.
std::vector<Vector3> crack_normals(const Model& model, std::uint32_t particle);

/// Whether any particle is of a material that breaks.
bool can_break(const Scene& scene, const Model& model);

/// Of each particle: the stretch less one at which its bonds break; infinite where they do not. Of a fracture
/// energy the one by which parting takes it (separation.h), on the mean over crack_normals(); a body's
/// fullest neighbourhood stands for the others. Throws Error(usage) for the projective law, whose shape
/// tensors do not know of broken bonds.
std::vector<double> critical_stretches(const Scene& scene, const Model& model);

/// Whether the segment from a to b meets a box (turned as `box` says). Throws Error(usage) for other shapes.
bool box_meets(const Shape& box, const Vector3& a, const Vector3& b);

} // namespace pliant
